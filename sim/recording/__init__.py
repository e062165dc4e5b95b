"""What a run leaves behind: telemetry and manifest."""
