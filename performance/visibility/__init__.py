"""How long the built-in trackers keep their target: `python -m performance.visibility [GROUP ...]`.

Runs visibility-v1 as a ranked run would, on seeds of our own. What was measured is kept in
docs/visibility.json, from which docs/visibility.md and its plots are made: a group that is not
named keeps its figures.
"""
