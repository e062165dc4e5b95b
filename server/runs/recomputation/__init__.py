"""Runs that are computed again: recomputations by an admin, and verifications."""
