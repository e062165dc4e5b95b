"""Runs followed, controlled and read by other people's libraries."""
