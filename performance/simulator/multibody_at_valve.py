"""A minute at a valve: a vehicle keeps its place in gusty water while its arm turns the handle."""

import time

import numpy as np

from seamark.sim.numerics.arrays import Array
from seamark.sim.physics.current import Current
from seamark.sim.physics.hydrodynamics import write_rotation
from tests.sim.multibody.scenes import JAW_ROTOR, STEP_S, vehicle_with_arm
from tests.sim.multibody.test_contacts import MINUTE, Scene

EVERY = 25  # steps between two commands
START = (0.055, 0.0, 5.0)
JAWS, START_JAWS = slice(11, 13), np.array([-0.3, 0.3])


class AtValve:
    """A vehicle in a current that keeps its place and turns a valve of 3 N m by its wrist."""

    STIFF = np.array([600.0, 600.0, 600.0, 60.0, 60.0, 60.0])
    DAMPED = np.array([200.0, 200.0, 200.0, 15.0, 15.0, 20.0])
    PER_S = 0.4  # of an error that stays
    TURNS_S = (8.0, 15.0)

    def __init__(self, *, iterations: int = 10, jaw_rotor: float = JAW_ROTOR) -> None:
        """Reach around the lever."""
        mechanism = vehicle_with_arm(valve_torque=3.0)
        for link in mechanism.links:
            if link.name in ("left", "right"):
                link.rotor = jaw_rotor
        mechanism.links[0].net_weight -= sum(link.net_weight for link in mechanism.links)
        self.mechanism = mechanism
        self.scene = Scene(mechanism, iterations=iterations)
        self.q = self.scene.state.q
        self.q[:3] = START
        self.q[10], self.q[JAWS] = 0.5 * np.pi, START_JAWS
        self.to_thrusts = np.linalg.pinv(mechanism.allocation)
        self.stays = np.zeros(6)
        self.touching = 0
        self.slack = 0.0  # [rad] most that the jaws, told to rest, have moved

    def thrusts(self) -> Array:
        """Return the thrusts that keep it at its place."""
        rotation = np.empty((3, 3))
        w, x, y, z = self.q[3:7]
        write_rotation(w, x, y, z, rotation)
        away = np.concatenate([rotation.T @ (self.q[:3] - START), 2.0 * self.q[4:7]])
        self.stays += self.PER_S * EVERY * STEP_S * away
        push = self.STIFF * (away + self.stays) + self.DAMPED * self.scene.state.v[:6]
        made: Array = -self.to_thrusts @ push
        return made

    def speeds(self, t: float) -> Array:
        """Return the speeds of the motors: the wrist turns for a while."""
        first, last = self.TURNS_S
        return np.array([0.0, 0.0, 0.0, 0.5 if first <= t < last else 0.0, 0.0])

    def run(self, current: Current) -> float:
        """Move for a minute and return the CPU time of the physics [s]."""
        scene, used = self.scene, 0.0
        scene.water = current.water
        for k in range(MINUTE // EVERY):
            scene.command.thrust[:] = self.thrusts()
            scene.command.speed[:] = self.speeds(k * EVERY * STEP_S)
            start = time.process_time()
            scene.run(EVERY)
            used += time.process_time() - start
            jaws = np.abs(self.q[JAWS] - START_JAWS)
            self.slack = max(self.slack, float(jaws.max()))
            self.touching += bool(scene.state.impulses.contact[:, 0].any())
        return used


def in_current(seed: int) -> Current:
    """Return gusty water of 0.22 m/s."""
    return Current(0.22, rng=np.random.Generator(np.random.PCG64(seed)), duration_s=60.0)
