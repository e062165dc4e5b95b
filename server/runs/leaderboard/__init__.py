"""Leaderboards: best rows, ranges of ranks, filters, reference entries."""
