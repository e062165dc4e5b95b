"""Does the order of entries depend on the version of the BlueROV2?

Runs the reference entries of `currents-v2` on both versions with the same seed, and keeps their
scores in `entries.json` beside this file, from which the page is written.
"""

import json
from collections.abc import Mapping, Sequence
from itertools import combinations
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from performance.tables import markdown_table
from seamark.sim.engine.trial import run_trial
from seamark.sim.engine.warm_up import warm_up
from seamark.sim.numerics.statistics import mean, mean_interval, percentile
from seamark.sim.registry import benchmark
from seamark.sim.vehicles import load

FILE = Path(__file__).with_name("entries.json")
BENCHMARK = "currents-v2"
VERSIONS = ("bluerov2-heavy", "bluerov2-heavy-v2")
SEED, TRIALS, PROCESSES = 2027, 12, 2
SETTINGS = {"tracker": "truth"}  # the order of controllers alone
RESAMPLES = 1000  # of the trials, for the interval of tau
OfVehicle = Mapping[str, Sequence[float]]  # entry -> score of each trial
Scores = Mapping[str, OfVehicle]  # by vehicle


def scores_of(vehicle: str, entry: str) -> list[float]:
    """Return the scores [m/s] of one entry on one vehicle, by trial, rounded to what is shown."""
    definition = benchmark(BENCHMARK)
    baseline = definition.baselines[entry]
    # With what a ranked run sets for this vehicle, such as that its tilt is held.
    own = load(vehicle).defaults
    config = definition.read({**own, **baseline.config, **SETTINGS, "vehicle": vehicle})
    scores = []
    for trial in range(TRIALS):
        solution = definition.load().built_in(baseline.built_in, config.for_trial(trial))
        result = run_trial(
            BENCHMARK, config, solution, seed=SEED, trial=trial, on_rows=lambda _rows: None
        )
        scores.append(round(float(result.score), 6))
    return scores


def main(_arguments: Sequence[str]) -> int:
    """Measure all entries on both versions and store their scores."""
    jobs = [(vehicle, entry) for vehicle in VERSIONS for entry in benchmark(BENCHMARK).baselines]
    with get_context("spawn").Pool(PROCESSES, initializer=warm_up) as pool:
        scores = pool.starmap(scores_of, jobs, chunksize=1)
    measured: dict[str, dict[str, list[float]]] = {vehicle: {} for vehicle in VERSIONS}
    for (vehicle, entry), found in zip(jobs, scores, strict=True):
        measured[vehicle][entry] = found
    FILE.write_text(json.dumps(measured, indent=1) + "\n", encoding="utf-8")
    return 0


def stored() -> Scores:
    """Return the scores that were stored."""
    scores: Scores = json.loads(FILE.read_text(encoding="utf-8"))
    return scores


def kendall(first: Sequence[float], second: Sequence[float]) -> float:
    """Return Kendall's tau (a): of all pairs, those in the same order less those in the other."""
    pairs = list(combinations(range(len(first)), 2))
    same = sum(_sign(first[a] - first[b]) * _sign(second[a] - second[b]) for a, b in pairs)
    return same / len(pairs)


def tau_of(first: OfVehicle, second: OfVehicle, trials: Sequence[int]) -> float:
    """Return Kendall's tau between the means of some trials on both versions."""
    means = (
        [mean([one[entry][at] for at in trials]) for entry in first] for one in (first, second)
    )
    return kendall(*means)


def tau_interval(first: OfVehicle, second: OfVehicle) -> tuple[float, float]:
    """Return the 95 % interval of tau by resampling trials, the same on both versions."""
    count = len(next(iter(first.values())))
    draws = np.random.default_rng(SEED).integers(count, size=(RESAMPLES, count)).tolist()
    taus = sorted(tau_of(first, second, draw) for draw in draws)
    return percentile(taus, 0.025), percentile(taus, 0.975)


def _sign(value: float) -> int:
    return (value > 0.0) - (value < 0.0)


def ranks(scores: Mapping[str, Sequence[float]]) -> dict[str, int]:
    """Return the rank of each entry by its mean, 1 for the best."""
    order = sorted(scores, key=lambda entry: -mean(scores[entry]))
    return {entry: at for at, entry in enumerate(order, start=1)}


def text() -> str:
    """Return the table and what it says."""
    scores = stored()
    first, second = (scores[vehicle] for vehicle in VERSIONS)
    places = ranks(first), ranks(second)
    rows = [
        (entry, *(cell for one, own in zip((first, second), places, strict=True)
                  for cell in (str(own[entry]), _held(one[entry]))))
        for entry in sorted(first, key=lambda entry: places[0][entry])
    ]  # fmt: skip
    tau = tau_of(first, second, range(len(next(iter(first.values())))))
    low, high = tau_interval(first, second)
    moved = [entry for entry in first if places[0][entry] != places[1][entry]]
    says = (
        f"The order of {len(first)} reference entries agrees with Kendall's tau {tau:.2f} (95 % "
        f"interval {low:.2f} to {high:.2f}); "
    ) + (f"other places have {', '.join(moved)}." if moved else "no entry changes its place.")
    header = ("entry", "place, first", "holds [m/s]", "place, second", "holds [m/s]")
    method = (
        f"Method: `{BENCHMARK}` on one vehicle, seed {SEED}, trials 0 to {TRIALS - 1}, the tracker "
        "that knows the truth; mean and 95 % interval over the trials, that of tau by resampling "
        "them. Differences smaller than the intervals are no order."
    )
    return "\n\n".join([f"**{says}**", markdown_table(header, rows), method])


def _held(scores: Sequence[float]) -> str:
    interval = mean_interval(list(scores))
    if interval is None:
        return f"{mean(scores):.3f}"
    return f"{mean(scores):.3f} ({interval[0]:.3f} to {interval[1]:.3f})"
