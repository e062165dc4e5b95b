"""What a log says about a vehicle: parameters, how sure they are, and how well they predict."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from seamark.identification.fit import Solution, excited, fit, noise, residuals_of
from seamark.identification.parameters import MOTIONS, axis_of, name_of, parameters_of, unit_of
from seamark.identification.series import CHANNELS, Series
from seamark.identification.whiteness import correlations, is_white
from seamark.mission_logs.result import LogRefused
from seamark.sim.numerics.arrays import Array, Flags
from seamark.sim.vehicles import Vehicle

HELD_OUT = 0.3  # of the windows, the last ones
_FEWEST = 3  # windows of each part, without which nothing is held out


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """One number of the vehicle; `margin` is half of its 95 % interval.

    It is None if the log does not tell this number, and of one that would be `below` zero.
    """

    index: int
    before: float
    value: float
    margin: float | None
    below: tuple[float, float] | None = None  # 95 % interval of the fit without bounds

    @property
    def name(self) -> str:
        """What people call it."""
        return name_of(self.index)

    @property
    def unit(self) -> str:
        """Its unit."""
        return unit_of(self.index)

    @property
    def interval(self) -> tuple[float, float] | None:
        """Its 95 % interval."""
        if self.margin is None:
            return None
        return self.value - self.margin, self.value + self.margin


@dataclass(frozen=True, kw_only=True)
class Prediction:
    """Root mean squares of measured minus predicted, of one channel: before and after the fit.

    `held_out` are those of the last windows, after a fit of the others; None if there are too few.
    `correlation` is that of successive residuals.
    """

    channel: str
    readings: int
    before: float
    after: float
    held_out: tuple[float, float] | None
    correlation: float


@dataclass(frozen=True, kw_only=True)
class Identified:
    """What a log says about a vehicle. `values` are its 18 numbers, none below zero."""

    values: Array
    parameters: tuple[Parameter, ...]
    predictions: tuple[Prediction, ...]
    white: bool  # else the intervals are those of windows that are independent of each other
    predicted: Array  # (n, 9) by the fitted vehicle
    windows: int
    not_judged: tuple[str, ...]  # motions that only the held out part excites

    @property
    def fitted(self) -> tuple[Parameter, ...]:
        """Those that the log tells."""
        return tuple(one for one in self.parameters if one.margin is not None or one.below)


def identify(series: Series, vehicle: Vehicle) -> Identified:
    """Return what a log says about a vehicle.

    Raises
    ------
    LogRefused
        Nothing in the log tells any parameter, or the fit comes to no end.
    """
    free = excited(series, vehicle, noise(series))
    if not free.any():
        raise LogRefused(
            "The log tells no parameter: the vehicle moves too little for the noise. Push it along "
            "each axis, both ways, at several strengths, and let it slow down in between."
        )
    unbounded = fit(series, vehicle, free)
    white = is_white(unbounded.residuals, series.windows)
    windows = len(series.windows)
    solution = _bounded(series, vehicle, unbounded)
    margins = solution.margins(robust=not white, windows=windows)
    wide = unbounded.margins(robust=not white, windows=windows)
    before = parameters_of(vehicle)
    parameters = []
    for index in range(len(before)):
        low = unbounded.values[index] - wide[index], unbounded.values[index] + wide[index]
        parameters.append(
            Parameter(
                index=index,
                before=float(before[index]),
                value=float(solution.values[index]),
                margin=float(margins[index]) if solution.free[index] else None,
                below=low if free[index] and not solution.free[index] else None,
            )
        )
    held_out, not_judged = _held_out(series, vehicle, free, solution.values)
    return Identified(
        values=solution.values,
        parameters=tuple(parameters),
        predictions=_predictions(series, vehicle, solution, held_out),
        white=white,
        predicted=series.measured - solution.residuals,
        windows=windows,
        not_judged=not_judged,
    )


def _bounded(series: Series, vehicle: Vehicle, solution: Solution) -> Solution:
    """Return the fit in which no number is below zero: such a one is zero, and the others refit."""
    while (wrong := solution.free & (solution.values < 0.0)).any():
        start = np.where(wrong, 0.0, solution.values)
        solution = fit(series, vehicle, solution.free & ~wrong, start=start)
    return solution


def _held_out(
    series: Series, vehicle: Vehicle, free: Flags, near: Array
) -> tuple[tuple[Array, Array] | None, tuple[str, ...]]:
    """Return the residuals of the last windows before and after a fit of the first ones.

    Also the motions that the first ones do not excite, though the whole log does.
    """
    windows = len(series.windows)
    kept = windows - round(HELD_OUT * windows)
    if min(kept, windows - kept) < _FEWEST:
        return None, ()
    first, last = series.part(slice(None, kept)), series.part(slice(kept, None))
    own = excited(first, vehicle, noise(first)) & free
    start = np.where(own, near, parameters_of(vehicle))  # near the end, so it is found quickly
    lost = sorted({axis_of(int(one)) for one in np.flatnonzero(free & ~own)})
    if not own.any():
        return None, tuple(MOTIONS[axis] for axis in lost)
    try:
        fitted = _bounded(first, vehicle, fit(first, vehicle, own, start=start))
    except LogRefused:  # the first part alone is too short to come to an end
        return None, ()
    sigma = noise(last)
    residuals = [
        residuals_of(last, vehicle, values, sigma)
        for values in (parameters_of(vehicle), fitted.values)
    ]
    return (residuals[0], residuals[1]), tuple(MOTIONS[axis] for axis in lost)


def _predictions(
    series: Series,
    vehicle: Vehicle,
    solution: Solution,
    held_out: tuple[Array, Array] | None,
) -> tuple[Prediction, ...]:
    before = residuals_of(series, vehicle, parameters_of(vehicle), solution.sigma)
    correlation, _ = correlations(solution.residuals, series.windows)
    made = []
    for at, channel in enumerate(CHANNELS):
        if not series.has(channel):
            continue
        judged = None if held_out is None else tuple(_rms(one[:, at]) for one in held_out)
        made.append(
            Prediction(
                channel=channel,
                readings=int(np.isfinite(solution.residuals[:, at]).sum()),
                before=_rms(before[:, at]),
                after=_rms(solution.residuals[:, at]),
                held_out=None if judged is None else (judged[0], judged[1]),
                correlation=float(correlation[at]),
            )
        )
    return tuple(made)


def _rms(values: Array) -> float:
    found = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(found**2))) if len(found) else float("nan")
