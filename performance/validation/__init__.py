"""The simulator against published results, closed forms and an independent solver.

`python -m performance.validation` writes docs/validation.md and its plots. One file per part.
"""
