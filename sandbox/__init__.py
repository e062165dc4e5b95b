"""Runs programs that are not trusted. Uses only the standard library."""
