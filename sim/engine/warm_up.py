"""Load everything that a run needs, so that a process forked afterwards starts at once.

Where nothing is compiled yet, several processes do that together.
"""

import os
from collections.abc import Callable, Iterable
from functools import cache, partial

import cv2

from seamark.sim import detectors, registry, trackers
from seamark.sim.control.mpc import horizon
from seamark.sim.control.observation import PIPE
from seamark.sim.engine.trial import run_trial
from seamark.sim.multibody import hull
from seamark.sim.numerics.numba_internals import numba_folder
from seamark.sim.numerics.shared_parts import run_parts
from seamark.sim.physics import plant

WITH_CAMERA = {"track-v1": {"route": PIPE}}  # what a benchmark's first trial does not have
WITH_ARM = {"vehicle": "bluerov2-heavy-v2", "arm": "alpha-like"}
OnPart = Callable[[int, int], None]


def warm_up(on_part: OnPart = lambda ready, of: None) -> None:
    """Load all registry entries and compiled code, and run each benchmark's shortest trial once.

    Parameters
    ----------
    on_part
        Is called with the index of each part when this process has loaded it, and the number of
        parts. Every function is stored as soon as it is compiled, so that a process that is
        stopped in the middle of a part has lost that function at most.
    """
    registry.load_all()
    # A run has one core, and threads that are made before a fork are not there after it.
    cv2.setNumThreads(1)
    # Large parts first; the registry lists the newest benchmarks first, and the others need less.
    parts = {"plant": plant.warm_up, "contacts": hull.warm_up, "trackers": trackers.warm_up}
    parts |= {"detectors": detectors.warm_up, "horizon": horizon.warm_up}
    parts |= {name: partial(_shortest_trial, name) for name in registry.BENCHMARKS}
    parts |= _further(registry.BENCHMARKS)
    parts["arm"] = partial(_shortest_trial, registry.DEFAULT_BENCHMARK, **WITH_ARM)
    parts["sonar"] = partial(_shortest_trial, "track-v1", sonar="forward")
    names = list(parts)
    run_parts(
        parts,
        numba_folder(os.environ),
        on_loaded=lambda name: on_part(names.index(name), len(names)),
    )


@cache
def warm_up_benchmark(name: str) -> None:
    """Load what runs of one benchmark need with its defaults; once in a process."""
    cv2.setNumThreads(1)
    run_parts({name: partial(_shortest_trial, name)} | _further([name]), numba_folder(os.environ))


def _further(names: Iterable[str]) -> dict[str, Callable[[], None]]:
    """Return the parts of benchmarks beside their shortest trials."""
    return {
        f"{name}-further": partial(_shortest_trial, name, **WITH_CAMERA[name])
        for name in names
        if name in WITH_CAMERA
    }


def _shortest_trial(name: str, **settings: object) -> None:
    benchmark = registry.benchmark(name)
    config = benchmark.read({**benchmark.quick_settings, **settings})
    solution = benchmark.load().built_in(next(iter(benchmark.built_in)), config.for_trial(0))
    run_trial(name, config, solution, seed=0, trial=0, on_rows=lambda _rows: None)
