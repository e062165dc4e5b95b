"""Settings of a run: what a setting is, and the groups that benchmarks share."""
