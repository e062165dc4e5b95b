"""Inside the box of a Python program: imports it and calls its methods."""
