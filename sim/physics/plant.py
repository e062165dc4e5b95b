"""The plant: state of a vehicle in a current, advanced by its thrusters, the water and contacts.

The equations of motion are in `dynamics.py`.
"""

import math

import numpy as np

from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.compilation import SameTypes
from seamark.sim.numerics.lent import Lent
from seamark.sim.physics import constants
from seamark.sim.physics.contact import Contact, lowest_point
from seamark.sim.physics.current import Current, Water
from seamark.sim.physics.dynamics import (
    RIGID,
    Afloat,
    Fault,
    Thrusters,
    add_impulse,
    advance_held,
    body_parameters,
    integration_buffers,
    write_acceleration,
    write_current,
)
from seamark.sim.physics.pose import read_pose, write_pose
from seamark.sim.physics.terrain import Bottom, draw_relief
from seamark.sim.physics.thruster_faults import ThrusterFault
from seamark.sim.physics.thrusters import (
    command_from_thrust,
    commands_for,
    pack_curve,
    thrust_from_command,
)
from seamark.sim.vehicles import Vehicle, load

STEP_S = constants.STEP_S.scalar


class Plant:
    """A vehicle in a current.

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
        thruster_gains: tuple[float, ...] | None = None,
    ) -> None:
        """Set up a plant; `thruster_gains` are the real thrusts over the nominal ones, else 1."""
        self.vehicle = vehicle
        self.current = current
        self.step_s = step_s
        self.contact = contact
        self.fault = fault
        self.body = body_parameters(vehicle)
        self.curve = pack_curve(vehicle.curve)  # (16,)
        self.thruster_gains = np.ones(len(vehicle.thrusters))
        if thruster_gains is not None:
            self.thruster_gains[:] = thruster_gains
        self._fault = Fault(-1 if fault is None else fault.thruster, np.zeros(1))
        self._command = np.zeros(len(vehicle.thrusters))  # a copy, of the type that is compiled for
        self._step = 0
        self._contact_force = 0.0
        self.state = np.zeros(RIGID + len(vehicle.thrusters))
        self._work = integration_buffers(len(self.state))
        target = np.zeros(len(vehicle.thrusters))
        self.afloat = Afloat(
            state=self.state,
            command=self._command,
            step_s=step_s,
            thrusters=Thrusters(self.curve, self.thruster_gains, target),
            fault=self._fault,
            body=self.body,
            water=current.water,
            work=self._work,
        )
        self._lent = Lent(self.afloat)
        self._advance_held = SameTypes(advance_held)
        self._write_acceleration = SameTypes(write_acceleration)
        self._write_current = SameTypes(write_current)
        self.state[3] = 1.0

    def reset(self, pose: Array) -> None:
        """Put the vehicle at rest at a pose, (6,) [m, rad], with no thrust."""
        self._step = 0
        self._contact_force = 0.0
        if self.fault is not None:
            self.fault.reset()
        self.state[:] = 0.0
        write_pose(np.array(pose, dtype=np.float64), self.state)

    def advance(self, step: int, command: Array, steps: int) -> None:
        """Advance the plant by a number of physics steps.

        Parameters
        ----------
        step : int
            Steps since the level began; the time is `step * step_s`.
        command : (n,) in [-1, 1]
            Constant over all steps.

        Raises
        ------
        ValueError
            A command is not a number, or the gust of the current is too short.
        """
        self._take_command(step, command, steps)
        self.finish(step, self._advance_freely(step, steps, self._gate()), steps)

    def begin(self, step: int, steps: int) -> float:
        """Begin steps with a command that compiled code takes; return the gate [m] to stop at.

        `afloat` is what it advances, to the end or to the gate, and then `finish` does the rest.
        This needs a plant without a fault, and no arm.

        Raises
        ------
        ValueError
            The gust of the current is too short.
        """
        if (step + steps) * self.step_s > self.current.duration_s + self.step_s:
            raise ValueError(f"the gust was drawn for only {self.current.duration_s} s")
        self._step = step + steps
        return self._gate()

    def finish(self, step: int, done: int, steps: int) -> None:
        """Advance by the rest of the steps since `step`, of which so many are done already."""
        step += done
        while step < self._step:
            self._advance_in_contact(step)
            step += 1
            if step < self._step:
                step += self._advance_freely(step, self._step - step, self._gate())
        if self.contact is not None:
            self._contact_force = self.contact.impulse_n_s / (steps * self.step_s)
            self.contact.impulse_n_s = 0.0

    def _gate(self) -> float:
        """Return the depth [m] at which things can touch: no step without them begins deeper."""
        if self.contact is None:
            return math.inf
        return -math.inf if self.contact.awake else self.contact.gate_depth

    def _take_command(self, step: int, command: Array, steps: int) -> None:
        """Keep a command, and what the faulty thruster makes of it, for steps that are coming."""
        if command.shape != self._command.shape:
            raise ValueError(
                f"the command must have shape {self._command.shape}, not {command.shape}"
            )
        self._command[:] = command
        if self.fault is not None:
            commanded = float(thrust_from_command(self._command[self.fault.thruster], self.curve))
            self._fault.thrust[0] = self.fault.apply(step, commanded)
        self.begin(step, steps)

    def _advance_freely(self, step: int, steps: int, gate: float) -> int:
        done = self._advance_held.call(self._lent, step, steps, gate)
        if done < 0:
            raise ValueError(f"thruster commands must be numbers: {list(self._command)}")
        return done

    def _advance_in_contact(self, step: int) -> None:
        if self.contact is None:
            raise RuntimeError("a plant without contacts was stopped at the gate")
        before = self.state.copy()
        self._advance_freely(step, 1, math.inf)
        impulse = self.contact.impulse(before, self.state, self.step_s)
        add_impulse(self.state, self.body.inverse_mass, impulse)

    def pose(self) -> Array:
        """Return (x, y, z, roll, pitch, yaw), (6,) [m, rad]."""
        out = np.empty(6)
        read_pose(self.state, out)
        return out

    def read_pose(self, out: Array) -> bool:
        """Write the pose to `out`, (6,) [m, rad]; return whether it and the velocity are finite."""
        finite: bool = read_pose(self.state, out)
        return finite

    @property
    def water(self) -> Water:
        """Return the current, for compiled code."""
        return self.current.water

    def velocity(self) -> Array:
        """Return the velocity over ground in the body frame, (6,) [m/s, rad/s]."""
        return self.state[7:13].copy()

    def thrust(self) -> Array:
        """Return the present thrust of each thruster, (n,) [N]."""
        return self.state[13:].copy()

    def acceleration(self) -> Array:
        """Return the acceleration over ground in the body frame, (6,) [m/s², rad/s²]."""
        out = np.empty(6)
        time_s = self._step * self.step_s
        self._write_acceleration.call(time_s, self.state, self.body, self.water, self._work, out)
        return out

    def contact_force(self) -> float:
        """Return the contact force [N] on the hull: mean magnitude over the last `advance`."""
        return self._contact_force

    def current_world(self, ahead_s: float = 0.0) -> Array:
        """Return the water's velocity now, or so much later, (3,) NED [m/s].

        Under the force law, where the water rests, it is the current that the force represents: to
        starboard its level, forward its lateral component.
        """
        out = np.empty(3)
        self._write_current.call(self._step * self.step_s + ahead_s, self.water, self.state, out)
        return out


def warm_up() -> None:
    """Load or compile every function of the physics, so that forked processes start at once."""
    vehicle = load("girona500")
    plant = Plant(vehicle, Current(0.1, rng=np.random.Generator(np.random.PCG64(0))))
    plant.reset(np.zeros(6))
    forces, state = np.zeros(len(vehicle.thrusters)), plant.state
    plant.advance(0, forces, 1)
    plant.pose()
    plant.current_world()
    add_impulse(state, plant.body.inverse_mass, np.zeros(6))
    commands_for(forces, plant.curve, forces.copy())
    command_from_thrust(1.0, plant.curve)
    thrust_from_command(0.5, plant.curve)
    lowest_point(state, np.zeros((1, 3)), np.zeros((1, 3)))
    mounds = draw_relief(np.random.Generator(np.random.PCG64(0)), height_m=0.1, flat_m=0.5)
    bottom = Bottom(5.0, mounds)
    bottom.sound([0.0] * 6)
    bottom.grid(1.0)
