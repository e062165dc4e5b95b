"""Runs: submission, lists, actions, checks, sweeps, comparison, publication."""
