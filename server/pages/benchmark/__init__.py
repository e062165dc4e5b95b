"""The pages of the benchmarks, and their settings as fields of a form."""
