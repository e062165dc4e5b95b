"""What all resources share: paths and queries, bodies, refusals, names of operations."""
