"""The simulator against what is published, what can be worked out by hand, and another solver.

`python -m performance.validation` writes docs/validation.md and its plots. One file per part.
"""
