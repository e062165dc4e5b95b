"""Random streams of one level: one independent generator per component.

A stream's seed depends on the trial's seed, the trial, the level and the component's fixed place
in the list, on nothing else (`OF_THE_TRIAL`: not on the level): a new sensor never changes the
waves, and the order in which streams are used does not matter.
"""

from dataclasses import dataclass, fields

import numpy as np


@dataclass(frozen=True, slots=True, kw_only=True)
class Streams:
    """The generators of one level. New names go to the end: the place is part of the seed."""

    gust: np.random.Generator
    dvl: np.random.Generator
    depth: np.random.Generator
    ahrs: np.random.Generator
    camera: np.random.Generator
    altimeter: np.random.Generator
    scene: np.random.Generator
    tracker: np.random.Generator
    start: np.random.Generator
    bottom: np.random.Generator


OF_THE_TRIAL = frozenset({"bottom"})  # the same in all levels: the bottom stays what it is


def streams(seed: int, trial: int, level: int) -> Streams:
    """Return fresh generators for one level of one trial.

    Parameters
    ----------
    seed : int
        Seed of the run, not negative, any size.
    trial, level : int
        Indices from zero.

    Raises
    ------
    ValueError
        When one of the numbers is negative.
    """
    if min(seed, trial, level) < 0:
        raise ValueError(f"seed, trial and level must not be negative: {seed}, {trial}, {level}")
    return Streams(
        **{
            field.name: np.random.Generator(
                np.random.PCG64(np.random.SeedSequence(entropy=seed, spawn_key=(trial, place, i)))
            )
            for i, field in enumerate(fields(Streams))
            for place in (0 if field.name in OF_THE_TRIAL else level,)
        }
    )
