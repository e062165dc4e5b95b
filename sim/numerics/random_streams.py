"""Random streams of one level: one independent generator per component.

The seed of a stream depends only on the trial's seed, the trial, the level and the index of the
component (those in `PER_TRIAL` not on the level): a new sensor never changes the gusts, and the
order in which streams are used does not matter.
"""

from dataclasses import dataclass, fields

import numpy as np


@dataclass(frozen=True, slots=True, kw_only=True)
class Streams:
    """The generators of one level. New names go to the end: the index is part of the seed."""

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
    trial_current: np.random.Generator
    trial_start: np.random.Generator
    trial_sensors: np.random.Generator
    trial_delays: np.random.Generator
    trial_vehicle: np.random.Generator
    trial_order: np.random.Generator


PER_TRIAL = frozenset(  # the same in all levels of a trial
    {
        *("bottom", "trial_current", "trial_start", "trial_sensors"),
        *("trial_delays", "trial_vehicle", "trial_order"),
    }
)


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
        One of the numbers is negative.
    """
    if min(seed, trial, level) < 0:
        raise ValueError(f"seed, trial and level must not be negative: {seed}, {trial}, {level}")
    return Streams(
        **{
            field.name: np.random.Generator(
                np.random.PCG64(
                    np.random.SeedSequence(entropy=seed, spawn_key=(trial, seeded_level, i))
                )
            )
            for i, field in enumerate(fields(Streams))
            for seeded_level in (0 if field.name in PER_TRIAL else level,)
        }
    )
