"""visibility-v3: trackers of a target that moves over the bottom, and whose wrong answers cost."""
