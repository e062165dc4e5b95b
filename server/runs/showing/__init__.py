"""Runs as pages and the API show them: views, lists, comparisons, pictures."""
