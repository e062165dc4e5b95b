"""What a run is measured by, computed from its telemetry."""
