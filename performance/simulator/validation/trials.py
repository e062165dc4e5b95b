"""Trials of the built-in controllers for the validation: telemetry and result."""

from collections.abc import Sequence
from contextlib import closing
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from seamark.sim.benchmarks.currents_v1.definition import CurrentsConfiguration
from seamark.sim.benchmarks.station_keeping.experiment import EXPERIMENT
from seamark.sim.engine.closed_loop import ClosedLoop
from seamark.sim.engine.program import BuiltIn
from seamark.sim.engine.tracker_in_loop import TrackerInLoop
from seamark.sim.engine.trial import TrialResult, run_trial
from seamark.sim.recording.telemetry import Rows
from seamark.sim.registry import benchmark

SEED = 1
BENCHMARK = "currents-v1"
PAPER_VEHICLE = "girona500-uwsim"


class Trial(NamedTuple):
    """One trial: the telemetry of all levels, and its result."""

    rows: Rows
    result: TrialResult


def configured(**values: object) -> CurrentsConfiguration:
    """Return a configuration of the benchmark; omitted settings are the vehicle's defaults."""
    config = benchmark(BENCHMARK).read(values)
    if not isinstance(config, CurrentsConfiguration):
        raise TypeError(f"{BENCHMARK} is configured by a {type(config).__name__}")
    return config


def trial(controller: str, *, seed: int = SEED, **values: object) -> Trial:
    """Run a built-in controller through all levels."""
    config = configured(**values)
    rows: list[Rows] = []
    program = BuiltIn(controller, config)
    result = run_trial(BENCHMARK, config, program, seed=seed, trial=0, on_rows=rows.append)
    return Trial(np.concatenate(rows), result)


def moved_level(
    controller: str,
    *,
    start_m: tuple[float, float] = (0.0, 0.0),
    corners_px: Sequence[Sequence[float]] | NDArray[np.float64],
    **values: object,
) -> Rows:
    """Return the telemetry of the first level from a start that no configuration offers.

    Parameters
    ----------
    start_m : (2,) [m]
        Start of the vehicle, north and east of the position above the target.
    corners_px : (4, 2) [px]
        Offset from the true corners at which the tracker is initialised.
    """
    config = configured(**values)
    rows: list[Rows] = []
    with closing(EXPERIMENT.world(config, seed=SEED, trial=0, level=0)) as world:
        pose = world.start.copy()
        pose[:2] += start_m
        world.plant.reset(pose)
        shift = np.array(corners_px, dtype=np.float64)
        world.tracking = TrackerInLoop(world.camera, config, shift)
        ClosedLoop(world, BuiltIn(controller, config), trial=0, level=0).run(rows.append)
    return np.concatenate(rows)
