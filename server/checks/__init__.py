"""Checks of a program before it is submitted."""
