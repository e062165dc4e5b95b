"""Classes and their assignments."""
