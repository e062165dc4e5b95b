"""Submitting runs: rules, quotas, sweeps, baselines."""
