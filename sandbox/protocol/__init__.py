"""What a box and the trusted side say to each other."""
