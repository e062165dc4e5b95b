"""Command line and Python client: what a participant touches."""
