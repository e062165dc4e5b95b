"""Interventions: what the benchmarks that compare vehicles with arms share."""
