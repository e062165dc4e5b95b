"""What the plant's equations predict of a log: the same compiled step that runs are made of.

The log is cut into windows. Each begins in a state of its own, since a vehicle in water forgets
where it began and a simulation over minutes would only add up small errors.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.identification.series import CHANNELS, Series
from seamark.sim.numerics.arrays import Array
from seamark.sim.physics.constants import STEP_S
from seamark.sim.physics.current import Water, segment_at
from seamark.sim.physics.dynamics import (
    RIGID,
    Body,
    Buffers,
    integration_buffers,
    runge_kutta_step,
)
from seamark.sim.physics.pose import read_pose, write_pose

_VELOCITY = 7  # of the plant's state
_ANGLES = 3  # of a pose


def predicted(series: Series, body: Body, starts: Array) -> Array:
    """Return what a body does in each window that begins in a given state.

    Parameters
    ----------
    starts : (w, 9)
        Of each window: u, v, w [m/s], p, q, r [rad/s], roll, pitch, yaw [rad].

    Returns
    -------
    (n, 9)
        The same at each row of the log; nan outside the windows and after a number overflows.
    """
    out = np.full((len(series.t), len(CHANNELS)), np.nan)
    size = RIGID + series.thrust.shape[1]
    _write_predictions(
        series.windows,
        starts,
        series.t,
        series.thrust,
        series.target,
        body._replace(allocation=series.allocation),
        series.water,
        integration_buffers(size),
        STEP_S.scalar,
        out,
    )
    return out


@njit(cache=True, error_model="numpy")
def _write_predictions(  # noqa: PLR0913, PLR0917  # all that compiled code reads
    windows: NDArray[np.int64],
    starts: Array,
    t: Array,
    thrust: Array,
    target: Array,
    body: Body,
    water: Water,
    work: Buffers,
    most_s: float,
    out: Array,
) -> None:
    """Write the channels at each row of the windows (w, 2) to `out`, (n, 9).

    Between two rows the thrust goes exponentially from its value in `thrust` to `target`, both
    (n, k). The time steps are equal parts of the interval and at most `most_s` long.
    """
    state = np.zeros(RIGID + thrust.shape[1])
    pose = np.zeros(6)
    grid = (water.top, water.spacing)
    for window in range(windows.shape[0]):
        first, after = windows[window, 0], windows[window, 1]
        state[:] = 0.0
        for i in range(3):
            pose[_ANGLES + i] = starts[window, 6 + i]
        write_pose(pose, state)
        for i in range(6):
            state[_VELOCITY + i] = starts[window, i]
        _write_row(state, pose, out[first])
        for row in range(first, after - 1):
            for j in range(thrust.shape[1]):
                state[RIGID + j] = thrust[row, j]
            span = t[row + 1] - t[row]
            steps = max(math.ceil(span / most_s - 1e-6), 1)
            for step in range(steps):
                begin, length = t[row] + step * (span / steps), span / steps
                segment = segment_at(begin + 0.5 * length, state[2], water.law, grid, water.drift)
                runge_kutta_step(state, target[row], (begin, length), body, (water, segment), work)
            if not _write_row(state, pose, out[row + 1]):
                break


@njit(cache=True, error_model="numpy")
def _write_row(state: Array, pose: Array, out: Array) -> bool:
    """Write velocity and attitude of `state` to `out`, (9,); return whether they are finite."""
    finite: bool = read_pose(state, pose)
    for i in range(6):
        out[i] = state[_VELOCITY + i]
    for i in range(3):
        out[6 + i] = pose[_ANGLES + i]
    return finite
