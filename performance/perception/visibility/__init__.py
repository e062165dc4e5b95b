"""Trackers in turbid water: docs/visibility.md."""
