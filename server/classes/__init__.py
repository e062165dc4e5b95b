"""Classes, their assignments and what the pupils made of them."""
