"""Fit one set of parameters on three trials, and the errors on the others."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import scipy  # its parts are loaded when they are used

from performance.simulator.validation.floating_arm.model import (
    NAMES,
    START,
    Parameters,
    balanced,
    parameters,
    predicted,
)
from performance.simulator.validation.floating_arm.records import FITTED, STEP_S, Trial
from seamark.sim.numerics.arrays import Array

_SIZES = np.array([1.0, 0.3, 0.1, 0.3, 0.3, 0.5, 0.5])  # by how much they may well differ
_LOW = np.array([0.5, -5.0, -5.0, 0.25, 0.25, 0.0, 0.0])
_HIGH = np.array([10.0, 5.0, 5.0, 3.0, 3.0, 5.0, 5.0])
_STATIC = NAMES.index("roll_inertia")  # numbers before it are all that a balance depends on
CLOCKS_S = np.round(np.linspace(-1.0, 1.0, 21), 1)
BLOCK_S = 5.0
RESAMPLES = 2000
_SEED = 28

Predictor = Callable[[Trial], Array]


@dataclass(frozen=True, slots=True, kw_only=True)
class Fitted:
    """What the trials of the fit give; `errors` are standard errors.

    They are computed as if one sample of ten, each second, were independent.
    """

    dynamic: Parameters
    errors: Array  # (k,)
    static: Parameters  # fitted as a balance of moments alone


def fit(trials: dict[str, Trial], names: Sequence[str] = FITTED) -> Fitted:
    """Return the parameters with the least squares of roll and pitch over some trials."""
    chosen, start = [trials[name] for name in names], START.values()
    best = scipy.optimize.least_squares(
        lambda values: _residuals(lambda trial: predicted(parameters(values), trial), chosen),
        start,
        bounds=(_LOW, _HIGH),
        x_scale=_SIZES,
        diff_step=1e-3,
    )
    weights = scipy.optimize.least_squares(
        lambda values: _residuals(
            lambda trial: balanced(parameters([*values, *start[_STATIC:]]), trial), chosen
        ),
        start[:_STATIC],
        x_scale=_SIZES[:_STATIC],
    )
    variance = 2.0 * best.cost / (best.fun.size * STEP_S)
    covariance = np.linalg.inv(best.jac.T @ best.jac) * variance
    return Fitted(
        dynamic=parameters(best.x),
        errors=np.sqrt(np.diag(covariance)),
        static=parameters([*weights.x, *start[_STATIC:]]),
    )


def predictors(fitted: Fitted) -> dict[str, Predictor]:
    """Return the engine's prediction and the trivial ones, by name."""
    return {
        "engine": lambda trial: predicted(fitted.dynamic, trial),
        "balance of moments": lambda trial: balanced(fitted.static, trial),
        "attitude at the start": lambda trial: np.repeat(
            trial.attitude[:1], len(trial.attitude), axis=0
        ),
    }


def residuals(predictor: Predictor, trials: dict[str, Trial]) -> dict[str, Array]:
    """Return prediction minus measurement of each trial, (n, 2) [deg]."""
    return {name: _error(predictor, trial) for name, trial in trials.items()}


def residuals_by_best_clock(predictor: Predictor, trials: dict[str, Trial]) -> dict[str, Array]:
    """Return the residuals with the clock of the joints that suits each trial best."""
    best = {}
    for name, trial in trials.items():
        candidates = [_error(predictor, trial.with_clock(float(shift))) for shift in CLOCKS_S]
        best[name] = min(candidates, key=lambda one: float(np.mean(one**2)))
    return best


def _error(predictor: Predictor, trial: Trial) -> Array:
    return np.degrees(predictor(trial) - trial.attitude)


def rms(errors: Sequence[Array]) -> Array:
    """Return the root mean squares of roll and pitch over trials of equal weight, (2,)."""
    squares: Array = np.mean([np.mean(each**2, axis=0) for each in errors], axis=0)
    return np.sqrt(squares)


def interval(errors: Sequence[Array], others: Sequence[Array] | None = None) -> Array:
    """Return the 95 % interval of the rms, or of its difference to that of `others`, (2, 2).

    Trials are drawn with replacement, then blocks of some seconds of each.
    """
    generator = np.random.Generator(np.random.PCG64(_SEED))
    values = []
    for _ in range(RESAMPLES):
        chosen = [_blocks(len(errors[i]), generator) for i in range(len(errors))]
        drawn = generator.integers(len(errors), size=len(errors))
        value = rms([errors[i][chosen[i]] for i in drawn])
        if others is not None:
            value = value - rms([others[i][chosen[i]] for i in drawn])
        values.append(value)
    limits: Array = np.percentile(values, [2.5, 97.5], axis=0)
    return limits


def _blocks(count: int, generator: np.random.Generator) -> Array:
    """Return samples of a trial drawn in blocks."""
    size = round(BLOCK_S / STEP_S)
    starts = generator.integers(count - size + 1, size=-(-count // size))
    samples: Array = np.ravel(starts[:, None] + np.arange(size))
    return samples


def _residuals(predictor: Predictor, trials: Sequence[Trial]) -> Array:
    return np.concatenate([np.ravel(predictor(trial) - trial.attitude) for trial in trials])
