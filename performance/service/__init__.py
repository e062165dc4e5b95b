"""What the service takes, and what others notice of it."""
