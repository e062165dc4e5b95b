"""The score of benchmarks in levels of current: an area over the current."""

from collections.abc import Mapping, Sequence
from typing import Any

from seamark.sim.numerics.statistics import area, mean


def area_over_current(levels: Sequence[Mapping[str, Any]], quality: str) -> float:
    """Return the area under a metric of the levels over the current [m/s].

    Below the weakest current it counts as there. In a grid a speed has several levels: their mean
    counts.
    """
    speeds = sorted({float(level["speed"]) for level in levels})
    means = [
        mean([float(level[quality]) for level in levels if level["speed"] == speed])
        for speed in speeds
    ]
    if speeds[0] > 0.0:
        speeds, means = [0.0, *speeds], [means[0], *means]
    return area(speeds, means)


def held_up_to(levels: Sequence[Mapping[str, Any]]) -> float | None:
    """Return the speed [m/s] up to which every level was held; None if not even the lowest."""
    held: float | None = None
    for speed in sorted({float(level["speed"]) for level in levels}):
        if not all(level["held"] for level in levels if level["speed"] == speed):
            break
        held = speed
    return held
