"""Tuning: tries configurations of a solution with the same seed and keeps the best."""
