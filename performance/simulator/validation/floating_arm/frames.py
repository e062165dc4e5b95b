"""Find where the arm's links point, from how the vehicle tilts while the arm moves slowly.

In a tilt that changes slowly, the moments of all weights balance: with s the sum of weight times
place in the vehicle, s is parallel to gravity. s has a part of the vehicle and one of each link, of
fixed length, that turns with the joints. Lengths are in shares of the vehicle's righting moment.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
import scipy  # its parts are loaded when they are used

from performance.simulator.validation.floating_arm.records import FITTED, Trial
from seamark.sim.numerics.arrays import Array

_DECIMATION = 5  # a sample each 0.5 s
_HEADINGS = 24
_FIRST_GUESS = (0.02, 0.16, 0.07, 3.07, -1.3, -2.6, -0.06, 0.07)
NAMES = (
    *("offset", "upper arm", "forearm", "base zero", "shoulder zero", "elbow zero"),
    *("trim ahead", "trim to starboard"),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Hypothesis:
    """How the joints could be arranged, and how well a balance of moments then fits."""

    upright: bool  # the base turns about the vertical, not about the axis ahead
    base_sign: int  # of the base's angle, seen from above positive to starboard
    elbow_sign: int
    rms_deg: float


def samples(trials: dict[str, Trial], names: Sequence[str] = FITTED) -> tuple[Array, Array]:
    """Return attitudes (n, 2) and joints (n, 4) of some trials."""
    chosen = [trials[name] for name in names]
    attitude = np.concatenate([trial.attitude[::_DECIMATION] for trial in chosen])
    return attitude, np.concatenate([trial.joints[::_DECIMATION] for trial in chosen])


def hypotheses(attitude: Array, joints: Array) -> list[Hypothesis]:
    """Return all arrangements, the best one first.

    Tilt is linear in the places of the weights: for each heading of the base at zero, the other
    numbers follow from linear least squares.
    """
    ranked = []
    for upright, base, elbow in product((True, False), (1, -1), (1, -1)):
        wanted = np.concatenate([attitude[:, 0], attitude[:, 1]])
        errors = []
        for zero in np.linspace(0.0, 2.0 * np.pi, _HEADINGS, endpoint=False):
            matrix = _design(joints, upright, base, elbow, float(zero))
            solution = np.linalg.lstsq(matrix, wanted, rcond=None)[0]
            errors.append(float(np.sqrt(np.mean((matrix @ solution - wanted) ** 2))))
        rms = float(np.degrees(min(errors)))
        ranked.append(Hypothesis(upright=upright, base_sign=base, elbow_sign=elbow, rms_deg=rms))
    return sorted(ranked, key=lambda one: one.rms_deg)


def _design(joints: Array, upright: bool, base: int, elbow: int, zero: float) -> Array:
    e, d, c = joints[:, 0], joints[:, 1], joints[:, 2]
    heading, upper = base * e - zero, d
    fore = d + elbow * c
    ones, none = np.ones_like(e), np.zeros_like(e)
    out = np.stack([ones, np.cos(upper), np.sin(upper), np.cos(fore), np.sin(fore)], axis=1)
    if upright:  # the weights move in the plane of the heading: roll by its sine, pitch its cosine
        arm = np.concatenate([out * np.sin(heading)[:, None], -out * np.cos(heading)[:, None]])
    else:  # about the axis ahead: to the side by the sine; ahead does not depend on it
        along = np.stack([none, np.sin(upper), -np.cos(upper), np.sin(fore), -np.cos(fore)], axis=1)
        arm = np.concatenate([out * np.sin(heading)[:, None], along])
    trims = np.concatenate([np.stack([ones, none], axis=1), np.stack([none, ones], axis=1)])
    return np.concatenate([arm, trims], axis=1)


def balance(joints: Array, numbers: Sequence[float] | Array, height: float = 1.0) -> Array:
    """Return roll and pitch, (n, 2), at which the moments of all weights balance.

    `numbers` are those of NAMES. `height` is how much an arm that is raised takes from the
    righting moment: 1 for weights that lie as found, -1 for their mirror image below.
    """
    offset, upper, fore, base, shoulder, elbow, ahead, starboard = numbers
    heading = -(joints[:, 0] - base)
    first = joints[:, 1] + shoulder
    second = first - (joints[:, 2] + elbow)
    out = offset + upper * np.cos(first) + fore * np.cos(second)
    up = upper * np.sin(first) + fore * np.sin(second)
    down = 1.0 - height * up
    side = starboard + out * np.sin(heading)
    roll = np.arctan2(side, down)
    return np.stack(
        [roll, -np.arctan2(ahead + out * np.cos(heading), np.hypot(side, down))], axis=1
    )


def identify(attitude: Array, joints: Array) -> tuple[Array, Array]:
    """Return the numbers of NAMES and their standard errors.

    Errors are computed as if one sample of ten were independent.
    """
    fit = scipy.optimize.least_squares(
        lambda numbers: np.ravel(balance(joints, numbers) - attitude), _FIRST_GUESS, method="lm"
    )
    variance = 2.0 * fit.cost / (fit.fun.size / 10.0)
    return fit.x, np.sqrt(np.diag(np.linalg.inv(fit.jac.T @ fit.jac)) * variance)


def height_share(attitude: Array, joints: Array) -> tuple[float, float]:
    """Return how much a raised arm takes from the righting moment, fitted, and its error.

    It is 1 if the arm's weights lie as found and -1 if they are mirrored below.
    """
    fit = scipy.optimize.least_squares(
        lambda values: np.ravel(balance(joints, values[:8], values[8]) - attitude),
        (*_FIRST_GUESS, 0.0),
        method="lm",
    )
    variance = 2.0 * fit.cost / (fit.fun.size / 10.0)
    error = np.sqrt(np.linalg.inv(fit.jac.T @ fit.jac)[8, 8] * variance)
    return float(fit.x[8]), float(error)
