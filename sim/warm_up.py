"""Load everything that a run needs, so that a process forked afterwards starts at once."""

from sim import dynamics, registry, trackers
from sim.program import BuiltIn
from sim.trial import run_trial

SHORTEST = {"levels": [0.1], "level_duration_s": 2.0, "settle_s": 1.0}


def warm_up(benchmark: str = "currents-v1") -> None:
    """Load all registry entries and compiled code, and run the shortest trial once."""
    registry.load_all()
    dynamics.warm_up()
    trackers.warm_up()
    config = registry.benchmark(benchmark).read(SHORTEST)
    program = BuiltIn("pi", config)
    run_trial(benchmark, config, program, seed=0, trial=0, on_rows=lambda _rows: None)
