"""Logs of real missions: read, checked, and measured by the metrics of a benchmark."""
