"""The queue: which run starts next, its lease, and how long the others wait."""
