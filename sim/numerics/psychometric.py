"""The level at which a solution fails: a psychometric function that falls over the levels.

The share of successes at level x is (1 - lapse rate) * S(x), where S is a logistic function that
falls from 1 to 0; the midpoint is where S is 1/2. The lapse rate takes the failures that have
nothing to do with the level, so that one unlucky trial at an easy level does not move the midpoint
(Wichmann & Hill 2001, https://doi.org/10.3758/BF03194544).

Estimated by the posterior on a grid, with the priors and the definition of the width of psignifit 4
(Schuett, Harmeling, Macke & Wichmann 2016, https://doi.org/10.1016/j.visres.2016.02.002).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.statistics import CONFIDENCE

LARGEST_LAPSE_RATE = 0.5
LAPSE_PRIOR = 10.0  # Beta(1, 10), as in psignifit
WIDTH_TO_SLOPE = 5.888877957572  # 2 ln 19: S falls from 95 % to 5 % over one width
POINTS = (101, 31, 26)  # of the grid: midpoint, width, lapse rate
NEGLIGIBLE = 1e-4  # share of the highest marginal density below which the second grid ends
DECIMALS = 9  # rounding removes the last bits of NumPy's exp and log, which differ by processor


@dataclass(frozen=True, slots=True, kw_only=True)
class PsychometricFit:
    """The most probable parameters, and the central 95 % of the midpoint's posterior."""

    midpoint: float  # in the unit of the levels; the range of the levels bounds it loosely
    low: float
    high: float
    width: float  # over which the share falls from 95 % to 5 % of its plateau
    lapse_rate: float  # 1 minus the plateau


def psychometric_midpoint(
    levels: Sequence[float], successes: Sequence[float], counts: Sequence[float]
) -> PsychometricFit | None:
    """Return the fitted midpoint, or None for fewer than two different levels.

    Parameters
    ----------
    levels
        Values of the levels, in any order; the harder a level, the larger its value.
    successes
        Number of successes at each level. Shares of a trial count as fractions: the images of one
        trial are not independent, so the unit is the trial, not the image.
    counts
        Number of trials at each level.
    """
    x, hits, trials = (np.asarray(each, dtype=float) for each in (levels, successes, counts))
    spacings = np.diff(np.unique(x))
    if not len(spacings):
        return None
    lowest, spread = float(np.min(x)), float(np.max(x) - np.min(x))
    narrowest = float(np.min(spacings))
    axes = (
        np.linspace(lowest - 0.5 * spread, lowest + 1.5 * spread, POINTS[0]),
        np.geomspace(narrowest, 3.0 * spread, POINTS[1]),
        np.linspace(0.0, LARGEST_LAPSE_RATE, POINTS[2]),
    )

    def posterior(axes: tuple[Array, Array, Array]) -> Array:
        prior = (
            _threshold_prior(axes[0], lowest, spread),
            _width_prior(axes[1], narrowest, spread),
            (LAPSE_PRIOR - 1.0) * np.log1p(-axes[2]),
        )
        log_density = _log_likelihood(axes, x, hits, trials) + _outer_sum(prior)
        return np.exp(np.round(log_density - np.max(log_density), DECIMALS))

    axes = _zoomed(axes, posterior(axes))
    return _fit(axes, posterior(axes))


def _log_likelihood(
    axes: tuple[Array, Array, Array], x: Array, hits: Array, trials: Array
) -> Array:
    """Return the binomial log likelihood on the grid, of the shape of the grid."""
    midpoint, width, lapse = axes
    scaled = (x - midpoint[:, None, None]) / width[:, None] * WIDTH_TO_SLOPE
    log_share = -np.logaddexp(0.0, scaled)  # (midpoint, width, level)
    result = np.empty((len(midpoint), len(width), len(lapse)))
    for at, rate in enumerate(lapse):
        plateau = 1.0 - float(rate)
        # A lapse rate of exactly 0 and S of 1 would make one failure impossible, not improbable.
        misses = np.log(np.maximum(1.0 - plateau * np.exp(log_share), 1e-12))
        result[:, :, at] = log_share @ hits + np.log(plateau) * np.sum(hits)
        result[:, :, at] += misses @ (trials - hits)
    return result


def _zoomed(axes: tuple[Array, Array, Array], density: Array) -> tuple[Array, Array, Array]:
    """Return a finer grid over the part of the axes where the density is not negligible."""
    ends = []
    for number, axis in enumerate(axes):
        marginal = np.max(density, axis=tuple({0, 1, 2} - {number}))
        inside = np.flatnonzero(marginal > NEGLIGIBLE)
        low, high = max(inside[0] - 1, 0), min(inside[-1] + 1, len(axis) - 1)
        ends.append((float(axis[low]), float(axis[high])))
    midpoint, width, lapse = ends
    return (
        np.linspace(*midpoint, POINTS[0]),
        np.geomspace(*width, POINTS[1]),
        np.linspace(*lapse, POINTS[2]),
    )


def _fit(axes: tuple[Array, Array, Array], density: Array) -> PsychometricFit:
    best = np.unravel_index(int(np.argmax(density)), density.shape)
    # The points of the width are spaced by its logarithm, its prior is uniform in the width itself.
    marginal = np.sum(np.sum(density, axis=2) * axes[1], axis=1)
    below = (np.cumsum(marginal) - 0.5 * marginal) / np.sum(marginal)
    margin = 0.5 * (1.0 - CONFIDENCE)
    low, high = np.round(np.interp((margin, 1.0 - margin), below, axes[0]), DECIMALS)
    midpoint, width, lapse = (float(axis[at]) for axis, at in zip(axes, best, strict=True))
    return PsychometricFit(
        midpoint=midpoint,
        low=min(float(low), midpoint),
        high=max(float(high), midpoint),
        width=width,
        lapse_rate=lapse,
    )


def _outer_sum(parts: tuple[Array, Array, Array]) -> Array:
    first, second, third = parts
    return first[:, None, None] + second[None, :, None] + third[None, None, :]


def _threshold_prior(midpoint: Array, lowest: float, spread: float) -> Array:
    """Return the log prior: uniform over the levels, falling to 0 over half their range outside."""
    outside = np.abs(midpoint - lowest - 0.5 * spread) - 0.5 * spread
    return _log_fall(2.0 * outside / spread)


def _width_prior(width: Array, narrowest: float, spread: float) -> Array:
    """Return the log prior of the width.

    It is uniform from twice the smallest spacing of the levels to their range, and falls to 0 at
    one spacing and at three times the range.
    """
    narrow = (2.0 * narrowest - width) / narrowest
    wide = (width - spread) / (2.0 * spread)
    return _log_fall(narrow) + _log_fall(wide)


def _log_fall(distance: Array) -> Array:
    """Return the logarithm of a raised cosine: 1 up to a distance of 0, then down to 0 at 1."""
    inside = np.clip(distance, 0.0, 1.0)
    return np.log(np.maximum(0.5 * (1.0 + np.cos(np.pi * inside)), 1e-300))
