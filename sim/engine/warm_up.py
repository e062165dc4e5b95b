"""Load everything that a run needs, so that a process forked afterwards starts at once."""

import cv2

from seamark.sim import registry, trackers
from seamark.sim.engine.trial import run_trial
from seamark.sim.physics import plant


def warm_up() -> None:
    """Load all registry entries and compiled code, and run each benchmark's shortest trial once."""
    registry.load_all()
    # A run has one core, and threads that are made before a fork are not there after it.
    cv2.setNumThreads(1)
    plant.warm_up()
    trackers.warm_up()
    for name in registry.BENCHMARKS:
        benchmark = registry.benchmark(name)
        config = benchmark.read(benchmark.quick_settings)
        solution = benchmark.load().built_in(next(iter(benchmark.built_in)), config)
        run_trial(name, config, solution, seed=0, trial=0, on_rows=lambda _rows: None)
