"""The service itself: health, metrics for Prometheus, what boxes contain."""
