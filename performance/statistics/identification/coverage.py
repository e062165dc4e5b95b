"""How often 95 % intervals of `seamark identify` hold the true parameters of synthetic logs.

    ./run performance identification_coverage [repetitions [noise]]

Two minutes of a tank day each, with other pushes, other noise and a start that is wrong by up to a
fifth. All 18 parameters are fitted. Takes ten minutes on two cores.
"""

from collections.abc import Sequence
from functools import partial
from multiprocessing import get_context

import numpy as np

from performance.statistics.identification.tank_day import log_of
from performance.tables import markdown_table
from seamark.identification.fit import fit
from seamark.identification.parameters import COUNT, name_of, parameters_of, vehicle_with
from seamark.identification.series import series_of
from seamark.identification.whiteness import is_white
from seamark.mission_logs.result import LogRefused
from seamark.sim.numerics.arrays import Array, Flags
from seamark.sim.vehicles import load

VEHICLE = "bluerov2-heavy-v2"
REPETITIONS = 200
SECONDS, PROCESSES = 120.0, 2
FIRST_SEED = 1000  # none of those with which the method was made
WRONG = 0.2  # greatest relative error of the start
_STREAM_OF_START = 2


def held(seed: int, *, noise: float = 1.0, seconds: float = SECONDS) -> Flags:
    """Return which intervals of one synthetic log hold the truth, (18,)."""
    vehicle = load(VEHICLE)
    truth = parameters_of(vehicle)
    factors = np.random.default_rng([seed, _STREAM_OF_START]).uniform(1 - WRONG, 1 + WRONG, COUNT)
    start = vehicle_with(vehicle, truth * factors)
    series = series_of(log_of(vehicle, seed, seconds=seconds, noise=noise), start)
    solution = fit(series, start, np.ones(COUNT, dtype=bool))
    robust = not is_white(solution.residuals, series.windows)
    margins = solution.margins(robust=robust, windows=len(series.windows))
    inside: Flags = np.abs(solution.values - truth) <= margins
    return inside


def _held_or_none(seed: int, *, noise: float) -> Flags | None:
    """Return the same of one log; None if it is refused."""
    try:
        return held(seed, noise=noise)
    except LogRefused:
        return None


def table(shares: Array, repetitions: int) -> str:
    """Return the table of shares (18,) [%]."""
    rows = [(name_of(at), f"{share:.1f}") for at, share in enumerate(shares.tolist())]
    rows.append(("**all**", f"**{shares.mean():.1f}**"))
    return markdown_table(("parameter", f"held in {repetitions} repetitions [%]"), rows)


def main(arguments: Sequence[str]) -> int:
    """Print the shares."""
    repetitions = int(arguments[0]) if arguments else REPETITIONS
    noise = float(arguments[1]) if len(arguments) > 1 else 1.0
    seeds = range(FIRST_SEED, FIRST_SEED + repetitions)
    with get_context("spawn").Pool(PROCESSES) as pool:
        inside = pool.map(partial(_held_or_none, noise=noise), seeds, chunksize=1)
    counts, answered = np.zeros(COUNT), 0
    for seed, one in zip(seeds, inside, strict=True):
        if one is None:
            print(f"seed {seed} is refused", flush=True)
            continue
        counts += one
        answered += 1
    print(table(100.0 * counts / max(answered, 1), answered))
    return 0
