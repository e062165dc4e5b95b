"""visibility-v1: trackers in water of growing turbidity."""
