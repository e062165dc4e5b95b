"""Loads and compiles everything that a run needs, before there is a run."""

from sim import registry
from sim import warm_up as simulator
from sim.program import BuiltIn
from sim.telemetry import Rows
from sim.trial import run_trial

_SHORT = {"levels": [0.1], "level_duration_s": 2.0, "settle_s": 0.0}


def warm_up() -> None:
    """Load all code, run two simulated seconds of every benchmark and throw away what they give."""
    simulator.warm_up()
    for name in registry.BENCHMARKS:
        config = registry.benchmark(name).read(_SHORT)
        run_trial(name, config, BuiltIn("pi", config), seed=0, trial=0, on_rows=_nothing)


def _nothing(_rows: Rows) -> None:
    """Take rows and do nothing with them."""
