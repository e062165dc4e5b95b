"""Bridges: programs that exist already take part in a benchmark over their own protocols."""
