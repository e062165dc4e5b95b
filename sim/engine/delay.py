"""Delays of the control loop, in whole control steps."""

from collections import deque

import numpy as np
from numpy.typing import NDArray

from seamark.sim.engine.program import Command

STILL: Command = (0.0, 0.0, 0.0, 0.0)  # of the vehicle; joints that are not commanded rest


class ImageDelay:
    """What the station keeper gets of the tracker's results, a number of control steps late.

    Until the first result has arrived again, it is the first one.
    """

    def __init__(self, corners: NDArray[np.float64], steps: int) -> None:
        """Set up a delay of `corners`, (8,) [px], which the tracker updates in place."""
        self._tracked = corners
        self._pending: deque[tuple[bool, NDArray[np.float64]]] = deque(maxlen=steps + 1)
        self.corners = corners.copy()
        self.ok = False

    def step(self, ok: bool) -> None:
        """Take the tracker's result of this control step; `ok` and `corners` are then the old."""
        self._pending.append((ok, self._tracked.copy()))
        self.ok, self.corners[:] = self._pending[0]


class CommandDelay:
    """Commands of a program on their way to the velocity controller; zero before the first."""

    def __init__(self, steps: int) -> None:
        self._pending = deque([STILL] * steps, maxlen=steps + 1)

    def step(self, command: Command) -> Command:
        """Take a command and return the one that arrives now."""
        self._pending.append(command)
        return self._pending[0]
