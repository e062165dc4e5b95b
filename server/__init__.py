"""The web process and the database."""
