"""Metrics of a run, computed from its telemetry."""
