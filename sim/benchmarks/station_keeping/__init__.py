"""Station keeping: what the benchmarks that compare position controllers share."""
