"""What a box costs a program, gives it, and leaves behind."""
