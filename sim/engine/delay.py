"""Delays of the control loop, in whole control steps."""

from collections import deque

import numpy as np
from numba import njit

from seamark.sim.engine.program import Command
from seamark.sim.numerics.arrays import Array

RESULT = 9  # numbers of a tracker's result: four corners [px], and whether it has the target
_CORNERS = RESULT - 1
STILL: Command = (0.0, 0.0, 0.0, 0.0)  # of the vehicle; joints that are not commanded rest


class ImageDelay:
    """What the station keeper gets of the tracker's results, a number of control steps late."""

    def __init__(self, steps: int) -> None:
        self.results = np.zeros((steps + 1, RESULT))  # for `arriving`
        self.corners = np.zeros(_CORNERS)  # [px]
        self.ok = False


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def arriving(results: Array, step: int, late: int, corners: Array, visible: bool) -> Array:
    """Keep the tracker's result of a control step and return the one that arrives now, (RESULT,).

    Until the first result has arrived again, it is the first one.

    Parameters
    ----------
    results : (late + 1 or more, RESULT)
        Those that are on their way.
    corners : (8,) [px]
        Where the tracker last had the target.
    """
    slots = results.shape[0]
    now = results[step % slots]
    now[:_CORNERS] = corners
    now[_CORNERS] = visible
    arrived: Array = results[max(step - late, 0) % slots]
    return arrived


class CommandDelay:
    """Commands of a program on their way to the velocity controller; zero before the first."""

    def __init__(self, steps: int) -> None:
        self._pending = deque([STILL] * steps, maxlen=steps + 1)

    def step(self, command: Command) -> Command:
        """Take a command and return the one that arrives now."""
        self._pending.append(command)
        return self._pending[0]
