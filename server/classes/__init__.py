"""Classes, their assignments and what the students made of them."""
