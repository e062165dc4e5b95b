"""The simulator against published results, closed forms and an independent solver.

`page` writes docs/validation.md and its plots; each section has a file.
"""
