"""GNU Octave in a box: what it needs of the host, and the program that it runs there."""
