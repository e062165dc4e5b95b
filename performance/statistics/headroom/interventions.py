"""Measure the reference entries of an intervention benchmark and write their table and plots.

    ./run performance intervention_headroom BENCHMARK [ENTRY ...] [--trials N] [--seed S]
        [--processes P]

Named entries are measured again, by default those that docs/headroom.json does not have yet with
these trials. They are those of `seamark run BENCHMARK --controller ENTRY --seed S --trials N`.
"""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import NamedTuple

from performance import DOCS
from performance.statistics.headroom import over_current
from performance.statistics.headroom.over_current import (
    HALVES,
    Headroom,
    Measured,
    at_speeds,
    insert,
    of_parts,
)
from performance.tables import markdown_table
from seamark.sim.numerics.statistics import mean
from seamark.sim.registry import benchmark

SEED, TRIALS = 777, 24  # neither the reference seed nor one that controllers were tuned on
SCORES = {
    "recover-v1": "recovered up to",
    "valve-v1": "turned up to",
    "connect-v1": "plugged up to",
    "mission-v1": "mission done up to",
}
# Further metrics of a level that are kept, as the share of levels of all currents [%].
FURTHER = {"mission-v1": ("found", "recognised", "taken", "wrong")}
OWN = ("scripted", "resolved-rate", "oracle")  # that are set beside what others published


class Published(NamedTuple):
    """What others published of a task like ours, at the weakest currents."""

    whose: str
    what: str  # is counted; it tells the tables of a page apart
    shares: tuple[str, ...]  # [%] at 0 m/s and so on


# WasserMan, arXiv 2610.04536: RotateValve, and the plug: 0 to 2 of 30, a range without currents.
PUBLISHED = {
    "valve-v1": Published("WasserMan, diffusion policy", "success", ("87.8", "64.4", "68.9")),
    "connect-v1": Published("WasserMan, learned policies", "plugged", ("0.0 to 6.7",) * 3),
}


def columns(speeds: Sequence[float], further: Sequence[str], one: Measured) -> Mapping[str, str]:
    """Return what the table has beside the score: how often the last stage was reached, and more.

    `further` are other metrics of a level, whose mean over all levels it has.
    """
    shares = at_speeds(speeds, one.levels["completed"]).items()
    done = {f"done at {speed:g} m/s, %": f"{100.0 * share:.0f}" for speed, share in shares}
    more = {f"{name}, %": f"{100.0 * mean(one.levels[name]):.0f}" for name in further}
    return done | more | of_parts(one, HALVES)


def plan(name: str) -> Headroom:
    """Return what is measured of an intervention benchmark."""
    further = FURTHER.get(name, ())
    return Headroom(
        benchmark=name,
        command=f"intervention_headroom {name}",
        seed=SEED,
        trials=TRIALS,
        seed_per_trial=False,
        score=SCORES[name],
        curve="credit",
        levels=("credit", "completed", *further),
        columns=partial(columns, benchmark(name).read({}).level_values(), further),
        parts=HALVES,
    )


def published_table(name: str, entries: Mapping[str, Measured]) -> str:
    """Return the Markdown table of what others published beside our entries [%]."""
    published, definition = PUBLISHED[name], benchmark(name)
    speeds = definition.read({}).level_values()[: len(published.shares)]
    first, *others = (f"{speed:g} m/s" for speed in speeds)
    ours = (
        (
            definition.baselines[own].title,
            *(f"{100.0 * one:.1f}" for one in entries[own].levels["completed"][: len(speeds)]),
        )
        for own in OWN
    )
    rows = ((published.whose, *published.shares), *ours)
    return markdown_table(("entry", f"{published.what} [%] at {first}", *others), rows)


def main(arguments: Sequence[str]) -> int:
    """Measure what is missing or named, then write table and plots."""
    name, *rest = arguments or ("--help",)
    if name not in SCORES:
        print(f"{__doc__}\nBENCHMARK is one of: {', '.join(SCORES)}")
        return 2
    code = over_current.main(plan(name), rest)
    if name in PUBLISHED:
        text = published_table(name, plan(name).known())
        print(text)
        insert(DOCS / "benchmarks.md", text)
    return code
