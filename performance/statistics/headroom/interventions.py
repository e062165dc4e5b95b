"""Measure the reference entries of an intervention benchmark and write their table and plots.

    ./run performance intervention_headroom BENCHMARK [ENTRY ...] [--trials N] [--seed S]
        [--processes P]

Named entries are measured again, by default those that docs/headroom.json does not have yet with
these trials. They are those of `seamark run BENCHMARK --controller ENTRY --seed S --trials N`.
"""

from collections.abc import Mapping, Sequence
from functools import partial

from performance.statistics.headroom import over_current
from performance.statistics.headroom.over_current import HALVES, Headroom, Measured, of_parts
from seamark.sim.registry import benchmark

SEED, TRIALS = 777, 24  # neither the reference seed nor one that controllers were tuned on
SCORES = {"recover-v1": "recovered up to", "valve-v1": "turned up to"}


def columns(speeds: Sequence[float], one: Measured) -> Mapping[str, str]:
    """Return what the table has beside the score: how often the last stage was reached."""
    shares = zip(speeds, one.levels["completed"], strict=True)
    done = {f"done at {speed:g} m/s, %": f"{100.0 * share:.0f}" for speed, share in shares}
    return done | of_parts(one, HALVES)


def plan(name: str) -> Headroom:
    """Return what is measured of an intervention benchmark."""
    return Headroom(
        benchmark=name,
        command=f"intervention_headroom {name}",
        seed=SEED,
        trials=TRIALS,
        seed_per_trial=False,
        score=SCORES[name],
        curve="credit",
        levels=("credit", "completed"),
        columns=partial(columns, benchmark(name).read({}).level_values()),
        parts=HALVES,
    )


def main(arguments: Sequence[str]) -> int:
    """Measure what is missing or named, then write table and plots."""
    name, *rest = arguments or ("--help",)
    if name not in SCORES:
        print(f"{__doc__}\nBENCHMARK is one of: {', '.join(SCORES)}")
        return 2
    return over_current.main(plan(name), rest)
