"""Tuning: tries configurations of a solution in the same water and keeps the best."""
