"""What simulating takes beside other libraries, and whether it is right."""
