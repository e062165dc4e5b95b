"""Least squares between what was measured and what the plant's equations predict.

The velocities are simulated from what drove the vehicle, never differentiated: noise of a measured
velocity in the place of the true one would pull drag towards zero, and differences would make the
noise of an acceleration. Each window's first state is estimated with the parameters and eliminated
from the normal equations, window by window (the Schur complement of a block arrow matrix), so a
log may be long. Each channel is weighted by the variance of its residuals.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from seamark.identification.parameters import COUNT, body_with, parameters_of, scales_of
from seamark.identification.prediction import predicted
from seamark.identification.series import CHANNELS, VELOCITIES, Series
from seamark.mission_logs.result import LogRefused
from seamark.sim.numerics.arrays import Array, Flags
from seamark.sim.numerics.student_t import quantile
from seamark.sim.physics.dynamics import Body
from seamark.sim.vehicles import Vehicle

CONFIDENCE = 0.95
ITERATIONS_MAX = 25  # with the same weights
REWEIGHTED_MAX = 3  # times that the channels are weighted anew
SHORT_S = 1.0  # of the windows that the fit begins with
_SAME_SIGMA = 0.05  # relative change
_DAMPING, _MORE, _LESS, _MOST_DAMPING = 1e-6, 10.0, 10.0, 1e6
# Steps of differences. Masses and drags that grow together change the motion so little beside all
# else that the error of a difference would look like information, and make the intervals too
# narrow: by a factor of nine in some logs with a central step of 1e-4. From 3e-6 on they no longer
# change.
_FORWARD_STEP, _CENTRAL_STEP = 1e-6, 3e-6
# A step that lowers the weighted sum of squares by less is the last: 0.03 belongs to a sixth of a
# standard error.
_ENOUGH, _ENOUGH_SHARE = 0.03, 1e-6
_ROUGH = 0.02  # [m/s, rad/s, rad] weight of all channels until the vehicle is roughly known
_LEAST_SIGMA = 1e-6  # a log without noise
_FINER = 10.0  # the weights grow in such steps, since a narrow valley is found from a wide one
_FAR = 1.0  # standard errors between the end of the iteration and where the equations point
# Standard error [m/s, rad/s, rad] of a first state that is left as it was read. At the end that
# must be far more than a reading may be wrong by, since what is left biases the parameters.
_UNTOLD_AT_FIRST, _UNTOLD = 0.3, 3.0
_TURNS = [CHANNELS.index("roll"), CHANNELS.index("yaw")]


@dataclass(frozen=True, kw_only=True)
class Solution:
    """Parameters that fit some windows, and how well.

    `values` are all 18 parameters; those not in `free` are the vehicle's own. `covariance` is
    (f, f) of the free ones. `residuals` are measured minus predicted, (n, 9), and `sigma` their
    standard deviation by channel, with the degrees of freedom that the fit takes up.
    """

    values: Array
    free: Flags
    covariance: Array
    robust: Array  # (f, f) the covariance if residuals of a window may depend on each other
    residuals: Array
    sigma: Array
    degrees: float

    def errors(self, *, robust: bool) -> Array:
        """Return standard errors, (18,), nan of what was not fitted.

        With `robust`, each is the larger of both kinds.
        """
        out = np.full(COUNT, np.nan)
        variance = np.diag(self.covariance)
        if robust:
            variance = np.maximum(variance, np.diag(self.robust))
        out[self.free] = np.sqrt(variance)
        return out

    def margins(self, *, robust: bool, windows: int) -> Array:
        """Return half the width of the 95 % intervals, (18,)."""
        degrees = max(windows - 1.0, 1.0) if robust else self.degrees
        return quantile(0.5 * (1.0 - CONFIDENCE), degrees) * self.errors(robust=robust)


class _Problem:
    """The least squares problem of some windows of a log."""

    def __init__(
        self, series: Series, vehicle: Vehicle, free: Flags, *, central: bool = False
    ) -> None:
        self.series = series
        self.central = central
        self.vehicle = vehicle
        self.free = np.flatnonzero(free)
        self.scales = scales_of(vehicle)
        self.rows = [slice(int(a), int(b)) for a, b in series.windows]
        self.used = np.isfinite(series.measured)
        self.states = _told_states(series)

    def body(self, values: Array) -> Body | None:
        return body_with(self.vehicle, values)

    def residuals(self, values: Array, starts: Array) -> Array | None:
        """Return measured minus predicted, (n, 9), nan where nothing was measured."""
        body = self.body(values)
        if body is None:
            return None
        residuals = self.series.measured - predicted(self.series, body, starts)
        residuals[:, _TURNS] = _wrapped(residuals[:, _TURNS])
        for rows in self.rows:
            if not np.isfinite(residuals[rows][self.used[rows]]).all():
                return None
        return residuals

    def cost(self, residuals: Array, sigma: Array) -> float:
        scaled = residuals / sigma
        return float(sum(np.nansum(scaled[rows] ** 2) for rows in self.rows))

    def by_parameters(self, values: Array, starts: Array, at: Array) -> list[Array]:
        """Return the derivative of the prediction by each free parameter, in units of its scale."""
        columns = []
        for index in self.free:
            step = np.zeros(COUNT)
            step[index] = self.step * self.scales[index]
            ahead = self._predicted(values + step, starts)
            behind = self._predicted(values - step, starts) if self.central else None
            columns.append(self._slope(ahead, behind, at))
        return columns

    def by_states(self, values: Array, starts: Array, at: Array) -> list[Array]:
        """Return the derivative by each number of the first states, of all windows at once."""
        columns = []
        for index in self.states:
            step = np.zeros(len(CHANNELS))
            step[index] = self.step
            ahead = self._predicted(values, starts + step)
            behind = self._predicted(values, starts - step) if self.central else None
            columns.append(self._slope(ahead, behind, at))
        return columns

    @property
    def step(self) -> float:
        """How far a number is moved for a derivative: of a scale, or m/s, rad/s, rad."""
        return _CENTRAL_STEP if self.central else _FORWARD_STEP

    def _predicted(self, values: Array, starts: Array) -> Array:
        residuals = self.residuals(values, starts)
        if residuals is None:
            raise LogRefused(
                "The prediction overflows. Check the units of thrust or commands, and the vehicle."
            )
        return residuals

    def _slope(self, ahead: Array, behind: Array | None, at: Array) -> Array:
        """Return a slope from residuals, which have the sign of what was measured."""
        change = at - ahead if behind is None else behind - ahead
        change[:, _TURNS] = _wrapped(change[:, _TURNS])
        slope: Array = change / (self.step if behind is None else 2.0 * self.step)
        return slope


@dataclass(frozen=True, kw_only=True)
class _Window:
    """One window's equations, weighted; the m rows are what was measured in it."""

    basis: Array  # (m, s) orthonormal: what a change of the first state does
    back: Array  # (9, s) from that basis to the first state
    slopes: Array  # (m, f) by the parameters, in scales
    rest: Array  # (m, f) of them what no first state could do
    residual: Array  # (m,)
    channels: NDArray[np.int64]  # (m,)

    def first_state(self, move: Array) -> Array:
        """Return the step of the first state, (9,), that suits a step of the parameters."""
        step: Array = self.back @ (self.basis.T @ (self.residual - self.slopes @ move))
        return step


@dataclass(frozen=True, kw_only=True)
class _Lines:
    """The linearised equations, with the first states eliminated."""

    windows: tuple[_Window, ...]
    information: Array  # (f, f) of the parameters, in scales
    scores: Array  # (w, f)

    def step(self, damping: float) -> tuple[Array, Array]:
        """Return the step of the parameters in scales, (f,), and of the first states, (w, 9)."""
        damped = self.information + damping * np.diag(np.diag(self.information))
        move = np.linalg.lstsq(damped, self.scores.sum(axis=0), rcond=None)[0]
        moves = [one.first_state(move) / (1.0 + damping) for one in self.windows]
        return move, np.array(moves)


class _Point(NamedTuple):
    """Where the iteration ended."""

    values: Array  # (18,)
    starts: Array  # (w, 9)
    residuals: Array  # (n, 9)
    lines: _Lines  # about the last point but one, a small step away


def fit(series: Series, vehicle: Vehicle, free: Flags, *, start: Array | None = None) -> Solution:
    """Return the parameters with the least squares; those not in `free` keep their values.

    Raises
    ------
    LogRefused
        The equations overflow, or the iteration does not come to an end.
    """
    values = parameters_of(vehicle) if start is None else start.copy()
    short = _Problem(_with_short_windows(series), vehicle, free)
    rough = np.full(len(CHANNELS), _ROUGH)
    point = _solved(short, values, _measured_starts(short.series), rough)
    target = _sigma(short, point.residuals, point.lines)
    problem = _Problem(series, vehicle, free)
    first = np.searchsorted(short.series.windows[:, 0], series.windows[:, 0])
    starts = point.starts[first]
    while (rough > target).any():
        point = _solved(problem, point.values, starts, np.maximum(rough, target))
        starts, rough = point.starts, rough / _FINER
    problem = _Problem(series, vehicle, free, central=True)
    for _ in range(REWEIGHTED_MAX):
        sigma = _sigma(problem, point.residuals, point.lines)
        point = _solved(problem, point.values, starts, sigma)
        starts = point.starts
        if (np.abs(sigma / target - 1.0) < _SAME_SIGMA).all():
            break
        target = sigma
    return _solution(problem, point, sigma)


def residuals_of(series: Series, vehicle: Vehicle, values: Array, sigma: Array) -> Array:
    """Return the residuals (n, 9) of given parameters, with the first states that suit best."""
    problem = _Problem(series, vehicle, np.zeros(COUNT, dtype=bool))
    return _inside(problem, _solved(problem, values, _measured_starts(series), sigma).residuals)


def _with_short_windows(series: Series) -> Series:
    """Return the same log in windows so short that a wrong vehicle does not go astray in them."""
    windows: list[tuple[int, int]] = []
    for first, after in series.windows.tolist():
        count = max(round((series.t[after - 1] - series.t[first]) / SHORT_S), 1)
        edges = np.linspace(first, after, count + 1).astype(np.int64).tolist()
        windows += pairwise(edges)
    return replace(series, windows=np.array(windows, dtype=np.int64))


def _solved(problem: _Problem, values: Array, starts: Array, sigma: Array) -> _Point:
    """Return the point of least cost (Levenberg and Marquardt)."""
    residuals = _first_residuals(problem, values, starts)
    damping = _DAMPING
    for _ in range(ITERATIONS_MAX):
        lines = _linearised(problem, values, starts, residuals, sigma)
        cost = problem.cost(residuals, sigma)
        while True:
            move, moves = lines.step(damping)
            tried = values.copy()
            tried[problem.free] += move * problem.scales[problem.free]
            moved = starts + moves
            new = problem.residuals(tried, moved)
            if new is not None and problem.cost(new, sigma) <= cost:
                break
            damping = max(damping * _MORE, _DAMPING)
            if damping > _MOST_DAMPING:
                return _Point(values, starts, residuals, lines)
        values, starts, residuals, damping = tried, moved, new, damping / _LESS
        if cost - problem.cost(new, sigma) < max(_ENOUGH, _ENOUGH_SHARE * cost):
            return _Point(values, starts, residuals, lines)
    return _Point(values, starts, residuals, lines)


def excited(series: Series, vehicle: Vehicle, sigma: Array) -> Flags:
    """Return which parameters a log can tell, (18,).

    A parameter counts if its standard error, expected from what moved and from the noise, is below
    a half of its scale; the worst is left out first, and the others are then looked at again. This
    depends on the noise, not on how the fit ends, so it does not bias the intervals.
    """
    values, starts = parameters_of(vehicle), _measured_starts(series)
    problem = _Problem(series, vehicle, np.ones(COUNT, dtype=bool))
    residuals = _first_residuals(problem, values, starts)
    information = _linearised(problem, values, starts, residuals, sigma).information
    kept = list(range(COUNT))
    while kept:
        part = information[np.ix_(kept, kept)] + np.diag(np.full(len(kept), _RIDGE))
        errors = np.sqrt(np.diag(np.linalg.inv(part)))
        worst = int(errors.argmax())
        if errors[worst] < _TELLING:
            break
        del kept[worst]
    free = np.zeros(COUNT, dtype=bool)
    free[kept] = True
    return free


_RIDGE = 1e-6  # of the scaled information: a parameter without any has an error of 1000 scales
_TELLING = 0.5  # of a scale


def noise(series: Series) -> Array:
    """Return the noise of each channel, (9,), from its second differences; robust and rough."""
    out = np.full(len(CHANNELS), np.inf)
    for at in range(len(CHANNELS)):
        column = series.measured[:, at]
        column = column[np.isfinite(column)]
        if len(column) > 2:
            bends = column[2:] - 2.0 * column[1:-1] + column[:-2]
            out[at] = max(float(np.median(np.abs(bends))) / (0.6745 * np.sqrt(6.0)), 1e-4)
    return out


def _told_states(series: Series) -> list[int]:
    """Return which numbers of a window's first state are estimated: what the log can tell.

    An angular rate can be told from its angle.
    """
    told = {at for at, name in enumerate(CHANNELS) if series.has(name)}
    return sorted(told | {at - 3 for at in told if at >= 6})


def _measured_starts(series: Series) -> Array:
    """Return what the readings say about the beginning of each window, (w, 9); 0 without any.

    Velocities are interpolated: a DVL may see no bottom for seconds. Of an angle, which may jump by
    a turn, it is the nearest reading.
    """
    starts = np.zeros((len(series.windows), len(CHANNELS)))
    at = series.t[series.windows[:, 0]]
    for channel, name in enumerate(CHANNELS):
        read = np.flatnonzero(np.isfinite(series.measured[:, channel]))
        if not len(read):
            continue
        times, values = series.t[read], series.measured[read, channel]
        if name in VELOCITIES:
            starts[:, channel] = np.interp(at, times, values)
        else:
            nearest = np.rint(np.interp(at, times, np.arange(len(read)))).astype(np.int64)
            starts[:, channel] = values[nearest]
    return starts


def _first_residuals(problem: _Problem, values: Array, starts: Array) -> Array:
    residuals = problem.residuals(values, starts)
    if residuals is None:
        raise LogRefused(
            "With the vehicle as it is in the file, the prediction overflows. Check the units of "
            "thrust or commands, and the vehicle with `seamark vehicle check`."
        )
    return residuals


def _wrapped(angle: Array) -> Array:
    """Return angles wrapped to (-pi, pi]."""
    wrapped: Array = angle - 2.0 * np.pi * np.round(angle / (2.0 * np.pi))
    return wrapped


def _sigma(problem: _Problem, residuals: Array, lines: _Lines) -> Array:
    """Return the standard deviation of the residuals by channel, (9,); 1 of one without any."""
    squares, count = np.zeros(len(CHANNELS)), np.zeros(len(CHANNELS))
    for rows in problem.rows:
        squares += np.nansum(residuals[rows] ** 2, axis=0)
        count += problem.used[rows].sum(axis=0)
    degrees = np.maximum(count - _leverage(lines), 1.0)
    return np.where(count > 0.0, np.maximum(np.sqrt(squares / degrees), _LEAST_SIGMA), 1.0)


def _linearised(
    problem: _Problem, values: Array, starts: Array, residuals: Array, sigma: Array
) -> _Lines:
    """Return the equations about a point; the first states are eliminated window by window."""
    by_parameters = problem.by_parameters(values, starts, residuals)
    by_states = problem.by_states(values, starts, residuals)
    windows = []
    for rows in problem.rows:
        used = problem.used[rows]
        weight = np.broadcast_to(1.0 / sigma, used.shape)[used]
        slopes = _stacked(by_parameters, rows, used, weight)
        basis, singular, turned = np.linalg.svd(
            _stacked(by_states, rows, used, weight), full_matrices=False
        )
        told = singular > 1.0 / (_UNTOLD if problem.central else _UNTOLD_AT_FIRST)
        basis, back = basis[:, told], np.zeros((len(CHANNELS), int(told.sum())))
        back[problem.states] = turned[told].T / singular[told]
        windows.append(
            _Window(
                basis=basis,
                back=back,
                slopes=slopes,
                rest=slopes - basis @ (basis.T @ slopes),
                residual=residuals[rows][used] * weight,
                channels=np.nonzero(used)[1],
            )
        )
    return _Lines(
        windows=tuple(windows),
        information=np.sum([one.rest.T @ one.rest for one in windows], axis=0),
        scores=np.array([one.rest.T @ one.residual for one in windows]),
    )


def _leverage(lines: _Lines) -> Array:
    """Return the degrees of freedom that parameters and first states take from a channel, (9,)."""
    lost, hat = np.zeros(len(CHANNELS)), np.linalg.pinv(lines.information)
    for one in lines.windows:
        taken = (one.basis**2).sum(axis=1) + ((one.rest @ hat) * one.rest).sum(axis=1)
        lost += np.bincount(one.channels, weights=taken, minlength=len(CHANNELS))
    return lost


def _stacked(columns: Sequence[Array], rows: slice, used: Flags, weight: Array) -> Array:
    """Return weighted columns of what was measured in a window, (m, c)."""
    if not columns:
        return np.zeros((len(weight), 0))
    return np.stack([column[rows][used] * weight for column in columns], axis=1)


def _solution(problem: _Problem, point: _Point, sigma: Array) -> Solution:
    lines = _linearised(problem, point.values, point.starts, point.residuals, sigma)
    scales, windows = problem.scales[problem.free], len(problem.rows)
    inverse = np.linalg.pinv(lines.information)
    step, _ = lines.step(0.0)
    if (np.abs(step) > _FAR * np.sqrt(np.diag(inverse))).any():
        raise LogRefused(
            "The fit does not come to an end: the log does not belong to these equations. Check "
            "units and signs of thrust and velocities, and whether their times agree."
        )
    meat = lines.scores.T @ lines.scores * (windows / max(windows - 1, 1))
    count = sum(int(problem.used[rows].sum()) for rows in problem.rows)
    free = np.zeros(COUNT, dtype=bool)
    free[problem.free] = True
    return Solution(
        values=point.values,
        free=free,
        covariance=inverse * np.outer(scales, scales),
        robust=inverse @ meat @ inverse * np.outer(scales, scales),
        residuals=_inside(problem, point.residuals),
        sigma=_sigma(problem, point.residuals, lines),
        degrees=max(count - float(_leverage(lines).sum()), 1.0),
    )


def _inside(problem: _Problem, residuals: Array) -> Array:
    """Return the residuals (n, 9) inside the windows, nan elsewhere."""
    out = np.full_like(residuals, np.nan)
    for rows in problem.rows:
        out[rows] = residuals[rows]
    return out
