"""Measure the reference entries of currents-v3 or currents-v2 and write their table and plots.

    ./run performance headroom [currents-v2] [ENTRY ...] [--trials N] [--seed S] [--processes P]

Named entries are measured again, by default those that docs/headroom.json does not have yet with
these trials. The scenario is the ranked one. The first eight trials of currents-v3 are its
reference trials; trial i of currents-v2 has the seed S + i, none of which is a benchmark's.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from performance.statistics.headroom import over_current
from performance.statistics.headroom.over_current import (
    HALVES,
    Headroom,
    Measured,
    in_turn,
    of_parts,
)

VEHICLES = in_turn(("Girona 500", "BlueROV2 Heavy"))
FROZEN = "currents-v2"


def columns(one: Measured) -> Mapping[str, str]:
    """Return what the table has beside the score."""
    return of_parts(one, VEHICLES) | of_parts(one, HALVES)


PLAN = Headroom(
    benchmark="currents-v3",
    command="headroom",
    seed=2026,  # public, but not one that gains were tuned on
    trials=24,
    seed_per_trial=False,  # a run, whose trials divide the directions among themselves
    score="current held from all sides",
    curve="quality",
    levels=("quality",),
    columns=columns,
    parts=VEHICLES,
)
BEFORE = replace(
    PLAN,
    benchmark=FROZEN,
    command=f"headroom {FROZEN}",
    seed=3001,  # neither the reference seed nor one that gains were tuned on
    trials=48,
    seed_per_trial=True,
    score="current held",
)


def main(arguments: Sequence[str]) -> int:
    """Measure what is missing or named, then write table and plots."""
    frozen = [*arguments[:1]] == [FROZEN]
    return over_current.main(BEFORE if frozen else PLAN, arguments[frozen:])
