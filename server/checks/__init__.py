"""Checks: a short trial of a program before it is submitted."""
