"""The benchmarks that a page may name in its address."""

from flask import abort

from seamark.sim import registry
from seamark.sim.benchmarks.benchmark import Benchmark


def first() -> Benchmark:
    """Return the default benchmark."""
    return registry.benchmark(registry.DEFAULT_BENCHMARK)


def by_name(name: str) -> Benchmark:
    """Return a benchmark, or end the request with 404."""
    if name not in registry.BENCHMARKS:
        abort(404)
    return registry.benchmark(name)


def labels() -> dict[str, str]:
    """Return name -> title of all benchmarks."""
    return {name: registry.benchmark(name).title for name in registry.BENCHMARKS}


def menu() -> dict[str, dict[str, str]]:
    """Return heading -> name -> title: newest versions, without a heading, and earlier ones."""
    newest = {name: title for name, title in labels().items() if newer_than(name) is None}
    earlier = {name: title for name, title in labels().items() if name not in newest}
    return {"": newest, "Earlier versions": earlier}


def newer_than(name: str) -> str | None:
    """Return the name of the newest version of a benchmark that has a newer one."""
    newest = registry.newest_version(name)
    return None if newest == name else newest
