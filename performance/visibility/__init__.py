"""Trackers in turbid water: `python -m performance.visibility [GROUP ...]`.

Runs visibility-v1 like a ranked run, on known seeds. The results are stored in
docs/visibility.json, from which docs/visibility.md and its plot are generated; groups that are not
named keep their results.
"""
