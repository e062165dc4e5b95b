"""A run evaluated: trials, the program's box, checks."""
