"""Benchmarks by the names that stand in addresses."""

from flask import abort

from sim import registry
from sim.benchmarks import Benchmark


def first() -> Benchmark:
    """Return the benchmark that is shown where none was chosen."""
    return registry.benchmark(next(iter(registry.BENCHMARKS)))


def by_name(name: str) -> Benchmark:
    """Return a benchmark, or end the request with 404."""
    if name not in registry.BENCHMARKS:
        abort(404)
    return registry.benchmark(name)


def labels() -> dict[str, str]:
    """Return name -> title of all benchmarks."""
    return registry.labels(registry.BENCHMARKS)
