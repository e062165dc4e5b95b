"""The queue: from submitting a run to its end, without simulating."""
