"""Runs a program nobody trusts. Standard library only."""
