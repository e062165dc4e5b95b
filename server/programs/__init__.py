"""Uploaded programs: read without trust, stored under their hash."""
