"""visibility-v2: trackers in turbid water, and in fast motion."""
