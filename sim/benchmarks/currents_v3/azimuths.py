"""Directions of the current that are spread evenly over the trials of a run.

The circle has as many strata as a ranked run has fresh trials of each vehicle. The trials that
share a seed, such as the fresh ones of a run, walk through them in strides: any `STRATA`
consecutive trials of a vehicle have one each, and any three are 30 degrees apart if quadrants are
folded onto each other, as the limits of the thrusters nearly are. The first stratum is drawn, and
each trial draws its direction within its stratum: so every trial alone has any direction alike
(Cochran 1977, Sampling Techniques, ch. 5 and 8).
"""

import numpy as np

from seamark.sim.settings.two_vehicles import MEASURED

STRATA = 12  # of the circle
STRIDE = 5  # strata from one trial of a vehicle to the next: prime to STRATA
QUARTER = STRATA // 4  # strata between the two vehicles: where one is weak, the other is strong
KEY = 27  # of the random numbers, beside the trial; part of what a seed gives: it never changes


def azimuth_share(seed: int, trial: int) -> float:
    """Return the direction of a trial as a share of the circle, from -1 (included) to 1."""
    first, within = int(STRATA * _drawn(seed, 0)[0]), _drawn(seed, trial)[1]
    turn, vehicle = divmod(trial, len(MEASURED))
    stratum = (first + STRIDE * turn + QUARTER * vehicle) % STRATA
    return 2.0 * (stratum + within) / STRATA - 1.0


def _drawn(seed: int, trial: int) -> tuple[float, float]:
    """Return two numbers from 0 to 1; of the first trial, the first one is that of the run."""
    sequence = np.random.SeedSequence(entropy=seed, spawn_key=(trial, 0, KEY))
    run, own = np.random.Generator(np.random.PCG64(sequence)).random(2).tolist()
    return run, own
