"""The data of runs: files and objects, how long they are kept, how much room they take."""
