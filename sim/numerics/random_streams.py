"""Random streams of one level: one independent generator per component.

The seed of a stream depends only on the trial's seed, the trial, the level and the index of the
component (those in `PER_TRIAL` not on the level): a new sensor never changes the gusts, and the
order in which streams are used does not matter.
"""

import numpy as np

PER_TRIAL = frozenset(  # the same in all levels of a trial
    {
        *("bottom", "trial_current", "trial_start", "trial_sensors"),
        *("trial_delays", "trial_vehicle", "trial_order", "trial_work"),
        *("trial_calibration", "trial_water"),
    }
)


class Streams:
    """The generators of one level, each of which is made when it is first used.

    New names go to the end: the index is part of the seed.
    """

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
    arm: np.random.Generator
    trial_work: np.random.Generator
    trial_calibration: np.random.Generator
    trial_water: np.random.Generator
    things: np.random.Generator
    search: np.random.Generator
    route: np.random.Generator
    usbl: np.random.Generator
    turbulence: np.random.Generator
    waves: np.random.Generator
    record: np.random.Generator
    sonar: np.random.Generator

    def __init__(self, seed: int, trial: int, level: int) -> None:
        self._numbers = seed, trial, level

    def __getattr__(self, name: str) -> np.random.Generator:
        """Make a generator and keep it: Python asks here for what is not there yet."""
        if name not in NAMES:
            raise AttributeError(f"there is no random stream {name}")
        seed, trial, level = self._numbers
        key = (trial, 0 if name in PER_TRIAL else level, NAMES.index(name))
        sequence = np.random.SeedSequence(entropy=seed, spawn_key=key)
        generator = np.random.Generator(np.random.PCG64(sequence))
        setattr(self, name, generator)
        return generator


NAMES = tuple(Streams.__annotations__)


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
    return Streams(seed, trial, level)
