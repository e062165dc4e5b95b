"""Trials of the reference entries, in parallel processes."""

from collections.abc import Sequence
from multiprocessing import get_context
from typing import Any, NamedTuple

from seamark.sim.engine.trial import run_trial
from seamark.sim.engine.warm_up import warm_up
from seamark.sim.registry import benchmark

NAME = "currents-v2"


class Job(NamedTuple):
    """One trial of one entry."""

    entry: str
    trial: int
    seed: int


def measure(job: Job) -> dict[str, Any]:
    """Return seed, vehicle, score, and the quality of each level, of one trial."""
    entry = benchmark(NAME)
    baseline = entry.baselines[job.entry]
    config = entry.ranked(entry.read(baseline.config))
    program = entry.load().built_in(baseline.built_in, config.for_trial(job.trial))
    result = run_trial(
        NAME, config, program, seed=job.seed, trial=job.trial, on_rows=lambda _rows: None
    )
    return {
        "seed": job.seed,
        "vehicle": result.conditions["vehicle_name"],
        "score": result.score,
        "quality": [level["quality"] for level in result.levels],
    }


def measure_all(entry: str, seeds: Sequence[int], processes: int) -> list[dict[str, Any]]:
    """Return the trials of an entry, one for each seed."""
    jobs = [Job(entry, trial, seed) for trial, seed in enumerate(seeds)]
    with get_context("spawn").Pool(processes, initializer=warm_up) as pool:
        return pool.map(measure, jobs, chunksize=1)
