"""Contacts of a vehicle with the bottom and with the target: when they are computed, and what of.

The plant integrates its own motion and gets the impulse of all contacts of a step. The engine that
computes it is neither made nor called while contact is impossible (above the gate), so runs in
which nothing comes near anything are the same to the last bit with any engine.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numba import njit

from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.libm import cos, sin
from seamark.sim.physics import constants
from seamark.sim.physics.hydrodynamics import write_rotation
from seamark.sim.physics.terrain import Bottom
from seamark.sim.vehicles import Vehicle

GATE_M = constants.GATE_M.scalar
AWAKE_SPEED = 1e-3  # [m/s, rad/s] a slower target is at rest
CLEARANCE_M = 0.1  # a hull this far above everything cannot touch it within a step


@dataclass(frozen=True, slots=True, kw_only=True)
class TargetBox:
    """A box on the bottom; by default the experiment's black box, which can be pushed."""

    centre: tuple[float, float, float]  # [m] NED
    yaw: float = 0.0  # [rad]
    size: tuple[float, float, float] = (
        constants.TARGET_SIZE_M.value[0],
        constants.TARGET_SIZE_M.value[1],
        constants.TARGET_HEIGHT_M.scalar,
    )  # [m]
    mass: float = constants.TARGET_MASS_KG.scalar  # [kg]
    fixed: bool = False


class Engine(Protocol):
    """What computes contacts."""

    @property
    def impulses(self) -> Array:
        """Return those of the last step, (k, 3), from which the next one starts: a view."""
        ...

    def step(self, before: Array, after: Array, step_s: float) -> Array:
        """Return the impulse of all contacts on the hull, like `Contact.impulse`."""
        ...

    def box_pose(self) -> tuple[Array, Array]:
        """Return position (3,) [m] and quaternion w x y z (4,) of the box now."""
        ...

    def box_speed(self) -> float:
        """Return the largest component of the box's velocity [m/s, rad/s]; zero for a fixed one."""
        ...

    def close(self) -> None:
        """Release what it holds; a second call does nothing."""
        ...


MakeEngine = Callable[[Vehicle, Bottom, TargetBox | None], Engine]


class Contact:
    """The bottom, optionally a box on it, and the vehicle's hull. Close it after use.

    A fixed box behaves like the bottom: it does not move, so it stays where images show it.
    """

    def __init__(
        self,
        vehicle: Vehicle,
        bottom: Bottom,
        *,
        engine: MakeEngine,
        box: TargetBox | None = None,
        top_m: float = math.inf,
    ) -> None:
        """Set up contacts; the engine is made when something can touch.

        `top_m` is the least depth [m] of what else the engine has in the world.
        """
        top = min(bottom.top_m, top_m)
        if box is not None:
            top = min(top, box.centre[2] - 0.5 * box.size[2])
        self.gate_depth = top - GATE_M - vehicle.hull_radius()
        self.awake = False
        self.impulse_n_s = 0.0  # on the hull, summed over steps; the plant resets it
        self._top = top
        self._centres = np.array([piece.centre.value for piece in vehicle.hull])
        self._halves = 0.5 * np.array([piece.size.value for piece in vehicle.hull])
        self._vehicle = vehicle
        self._bottom = bottom
        self._box = box
        self._make_engine = engine
        self._engine: Engine | None = None

    def impulse(self, before: Array, after: Array, step_s: float) -> Array:
        """Return the contact impulse of one step.

        Parameters
        ----------
        before, after : (13 + n,)
            The plant's state at the start of the step, and at its end without contact.

        Returns
        -------
        (6,) [N s, N m s]
            About the origin, in the body frame of `before`.
        """
        if not self.awake:
            lowest = lowest_point(before, self._centres, self._halves)
            if lowest < self._top - CLEARANCE_M:
                return np.zeros(6)
        engine = self._made()
        impulse = engine.step(before, after, step_s)
        self.impulse_n_s += math.sqrt(
            impulse[0] * impulse[0] + impulse[1] * impulse[1] + impulse[2] * impulse[2]
        )
        self.awake = engine.box_speed() > AWAKE_SPEED
        return impulse

    def _made(self) -> Engine:
        if self._engine is None:
            self._engine = self._make_engine(self._vehicle, self._bottom, self._box)
        return self._engine

    def impulses(self) -> Array:
        """Return those from which the next step starts, (k, 3); none before any touch."""
        return np.zeros((0, 3)) if self._engine is None else self._engine.impulses

    def start_from(self, impulses: Array) -> None:
        """Take impulses of an equal hull, (k or more, 3); zeros are as before any touch."""
        if self._engine is not None or impulses.any():
            known = self._made().impulses
            known[:] = 0.0
            known[: len(impulses)] = impulses[: len(known)]

    def box_pose(self) -> tuple[Array, Array]:
        """Return position (3,) [m] and quaternion w x y z (4,) of the box now.

        Raises
        ------
        LookupError
            There is no box.
        """
        if self._box is None:
            raise LookupError("there is no box")
        if self._engine is None:
            half = 0.5 * self._box.yaw
            return np.array(self._box.centre), np.array([cos(half), 0.0, 0.0, sin(half)])
        return self._engine.box_pose()

    def close(self) -> None:
        """Release what the engine holds, if one was made."""
        if self._engine is not None:
            self._engine.close()
            self._engine = None


@njit(cache=True, error_model="numpy")
def lowest_point(state: Array, centres: Array, halves: Array) -> float:
    """Return the depth [m] of the lowest point of boxes (k, 3) along the body axes."""
    rotation = np.empty((3, 3))
    write_rotation(state[3], state[4], state[5], state[6], rotation)
    lowest = -np.inf
    for i in range(centres.shape[0]):
        depth = state[2]
        for j in range(3):
            depth += rotation[2, j] * centres[i, j] + abs(rotation[2, j]) * halves[i, j]
        lowest = max(lowest, depth)
    return lowest
