"""A vehicle in its current: its state, what it is commanded, and who moves it on: water or contact.

Its equations of motion stand in `sim/physics/dynamics.py`.
"""

import math
from typing import Any

import numpy as np

from seamark.sim.numerics.arrays import Array
from seamark.sim.physics import constants
from seamark.sim.physics.contact import Contact, add_push, lowest_point, world_motion
from seamark.sim.physics.current import Current
from seamark.sim.physics.dynamics import RIGID, add_impulse, body_of, drive, write_current
from seamark.sim.physics.pose import read_pose, write_pose
from seamark.sim.physics.terrain import Bottom, draw_relief
from seamark.sim.physics.thruster_faults import ThrusterFault
from seamark.sim.physics.thrusters import command_of, commands_for, force_of, packed
from seamark.sim.vehicles import Vehicle, load

STEP_S = constants.STEP_S.scalar


class Plant:
    """A vehicle in its current.

    `state` is (13 + n,): position NED of the body's origin [m], quaternion w x y z (body to world),
    velocity over ground in the body frame [m/s, rad/s], thrust of each thruster [N].
    """

    def __init__(
        self,
        vehicle: Vehicle,
        current: Current,
        *,
        step_s: float = STEP_S,
        contact: Contact | None = None,
        fault: ThrusterFault | None = None,
    ) -> None:
        self.vehicle = vehicle
        self.current = current
        self.step_s = step_s
        self.contact = contact
        self.fault = fault
        self._body = body_of(vehicle)
        # Plain tuples: Numba takes named ones from Python at several times the cost.
        self._plain_body, self._plain_water = tuple(self._body), tuple(current.water)
        self._curve = packed(vehicle.curve)
        self._target = np.zeros(len(vehicle.thrusters))  # [N] steady thrust of the command
        self._broken = (-1, 0.0)
        # A copy of its own: a read-only or foreign array would make Numba compile everything anew.
        self._command = np.zeros(len(vehicle.thrusters))
        self._tick = 0
        self._contact_force = 0.0
        self.state = np.zeros(RIGID + len(vehicle.thrusters))
        self.state[3] = 1.0

    def place(self, pose: Array) -> None:
        """Put the vehicle at rest at (x, y, z, roll, pitch, yaw), (6,) [m, rad]; thrusters stop."""
        self._tick = 0
        self._contact_force = 0.0
        if self.fault is not None:
            self.fault.reset()
        self.state[:] = 0.0
        write_pose(np.array(pose, dtype=np.float64), self.state)

    def advance(self, tick: int, command: Array, steps: int) -> None:
        """Move the plant by `steps` steps.

        Parameters
        ----------
        tick : int
            Steps since the level began; the time is `tick * step_s`.
        command : (n,) in [-1, 1]
            Held over all steps.

        Raises
        ------
        ValueError
            When a command is not a number, or the current was not made for so long.
        """
        if command.shape != self._command.shape:
            raise ValueError(f"a command for {self._command.size} thrusters, not {command.shape}")
        self._command[:] = command
        if self.fault is not None:
            wanted = float(force_of(self._command[self.fault.thruster], self._curve))
            self._broken = (self.fault.thruster, self.fault.given(tick, wanted))
        if (tick + steps) * self.step_s > self.current.duration_s + self.step_s:
            raise ValueError(f"the gust was drawn for {self.current.duration_s} s only")
        self._tick = tick + steps
        while tick < self._tick:
            tick += self._advance_freely(tick, self._tick - tick)
            if tick < self._tick:
                self._advance_in_contact(tick)
                tick += 1
        if self.contact is not None:
            self._contact_force = self.contact.felt / (steps * self.step_s)
            self.contact.felt = 0.0

    def _advance_freely(self, tick: int, steps: int, *, gate: float | None = None) -> int:
        if gate is None:
            gate = math.inf
            if self.contact is not None:
                gate = -math.inf if self.contact.awake else self.contact.gate_depth
        made: int = drive(
            self.state,
            *(self._command, self._curve, self._target, self._broken),
            (tick, steps, self.step_s, gate),
            *(self._plain_body, self._plain_water),
        )
        if made < 0:
            raise ValueError(f"thruster commands must be numbers: {list(self._command)}")
        return made

    def _advance_in_contact(self, tick: int) -> None:
        if self.contact is None:
            raise RuntimeError("a plant without contact was stopped at the gate")
        before = self.state.copy()
        self._advance_freely(tick, 1, gate=math.inf)
        push = self.contact.impulse(before, self.state, self.step_s)
        add_impulse(self.state, self._body.inverse_mass, push)

    def pose(self) -> Array:
        """Return (x, y, z, roll, pitch, yaw), (6,) [m, rad]."""
        out = np.empty(6)
        read_pose(self.state, out)
        return out

    def read_pose(self, out: Array) -> bool:
        """Write the pose to `out`, (6,) [m, rad]; tell whether it and the velocity are finite."""
        finite: bool = read_pose(self.state, out)
        return finite

    @property
    def water(self) -> tuple[Any, ...]:
        """Return the current as a plain tuple, for compiled code."""
        return self._plain_water

    def velocity(self) -> Array:
        """Return the velocity over ground in the body frame, (6,) [m/s, rad/s]."""
        return self.state[7:13].copy()

    def thrust(self) -> Array:
        """Return the present thrust of each thruster, (n,) [N]."""
        return self.state[13:].copy()

    def contact_force(self) -> float:
        """Return the size of the contacts' force on the hull, mean over the last `advance` [N]."""
        return self._contact_force

    def current_world(self) -> Array:
        """Return the water's velocity now, (3,) NED [m/s].

        Under the force law, where the water rests, it is the current that the force stands for:
        to starboard its level, forward its lateral part.
        """
        out = np.empty(3)
        write_current(self._tick * self.step_s, self._plain_water, self.state, out)
        return out


def warm_up() -> None:
    """Load or compile every function of the physics, so that a fork of this process need not."""
    vehicle = load("girona500")
    plant = Plant(vehicle, Current(0.1, rng=np.random.Generator(np.random.PCG64(0))))
    plant.place(np.zeros(6))
    forces, state, point = np.zeros(len(vehicle.thrusters)), plant.state, np.zeros(3)
    plant.advance(0, forces, 1)
    plant.pose()
    plant.current_world()
    add_impulse(state, plant._body.inverse_mass, np.zeros(6))
    commands_for(forces, plant._curve, forces.copy())
    command_of(1.0, plant._curve)
    force_of(0.5, plant._curve)
    lowest_point(state, np.zeros((1, 3)), np.zeros((1, 3)))
    world_motion(state, state, point, np.zeros(9))
    add_push(state, point, point, np.zeros(6))
    mounds = draw_relief(np.random.Generator(np.random.PCG64(0)), height_m=0.1, flat_m=0.5)
    bottom = Bottom(5.0, mounds)
    bottom.sound([0.0] * 6)
    bottom.grid(1.0)
