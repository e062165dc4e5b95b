"""Competitions: for everybody, for teams and for their organisers."""
