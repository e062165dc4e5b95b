"""Contacts computed by PyBullet, for comparison: the engine of `contacts = pybullet`.

The plant integrates its own motion; Bullet only computes the contact impulse of a step. Bullet has
only a scalar mass: it gets the rigid mass plus the smallest translational added mass. Less than the
true mass in a direction is stable (an impulse never overshoots), more is not; the remainder
converges over the next steps. Only the impulses at the contact points are used, so momentum is
conserved. The target has no drag; its weight is that in water.

PyBullet has a wheel for Python 3.11 alone, and its last bits depend on the processor.
"""

import ctypes
import importlib.util
import os
import weakref
from types import ModuleType

import numpy as np
from numba import njit

from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.libm import cos, sin
from seamark.sim.physics import constants
from seamark.sim.physics.contact import TargetBox
from seamark.sim.physics.hydrodynamics import write_rotation
from seamark.sim.physics.terrain import REACH_M, Bottom
from seamark.sim.vehicles import STANDARD_GRAVITY, Vehicle
from seamark.sim.vehicles.urdf import urdf_of

SOLVER_ITERATIONS = 50  # Bullet's default
CELL_M = 0.25  # of the mesh of the mounds: within a few mm of the waves
_FAR_M = 1000.0  # extent of the bottom beyond the mounds


def installed() -> bool:
    """Return whether PyBullet can be imported."""
    return importlib.util.find_spec("pybullet") is not None


class BulletEngine:
    """A PyBullet world: bottom, hull, box; see `physics.contact.Engine`."""

    def __init__(self, vehicle: Vehicle, bottom: Bottom, box: TargetBox | None) -> None:
        bullet = _import_bullet()
        self._bullet = bullet
        self._client = bullet.connect(bullet.DIRECT)
        self._close = weakref.finalize(self, bullet.disconnect, self._client)
        self._gravity_centre = np.array(vehicle.centre_of_gravity.value)
        self._motion = np.empty(9)
        bullet.setPhysicsEngineParameter(
            deterministicOverlappingPairs=1,
            numSolverIterations=SOLVER_ITERATIONS,
            physicsClientId=self._client,
        )
        # No gravity: the plant has the weight and the buoyancy of the vehicle.
        bullet.setGravity(0, 0, 0, physicsClientId=self._client)
        if bottom.relief is None:
            plane = bullet.createCollisionShape(
                bullet.GEOM_PLANE, planeNormal=[0, 0, -1], physicsClientId=self._client
            )
            self._add(plane, 0.0, (0.0, 0.0, bottom.depth_m))
        else:
            self._add_mounds(bottom)
        self._hull = self._add_hull(vehicle)
        self._box = None if box is None else self._add_box(box)
        self._box_moves = box is not None and not box.fixed
        self._box_weight = 0.0
        if box is not None:
            displaced = constants.WATER_DENSITY.scalar * box.size[0] * box.size[1] * box.size[2]
            self._box_weight = (box.mass - displaced) * STANDARD_GRAVITY

    def _add_mounds(self, bottom: Bottom) -> None:
        """Add the mounds as a height field, and boxes around it for the flat bottom."""
        bullet, (north, east) = self._bullet, bottom.centre
        # Bullet's heights point up: half a turn about north turns them into depths.
        heights = -bottom.grid(CELL_M)[:, ::-1]
        field = bullet.createCollisionShape(
            bullet.GEOM_HEIGHTFIELD,
            meshScale=[CELL_M, CELL_M, 1.0],
            heightfieldData=heights.T.ravel().tolist(),
            numHeightfieldRows=len(heights),
            numHeightfieldColumns=len(heights),
            physicsClientId=self._client,
        )
        middle = -0.5 * float(heights.min() + heights.max())  # origin of Bullet's height field
        self._add(field, 0.0, (north, east, middle), (1.0, 0.0, 0.0, 0.0))
        half, off = 0.5 * _FAR_M, REACH_M + 0.5 * _FAR_M
        for x, y, size in ((1, 0, (half, _FAR_M)), (0, 1, (REACH_M, half))):
            shape = bullet.createCollisionShape(
                bullet.GEOM_BOX, halfExtents=[*size, half], physicsClientId=self._client
            )
            for side in (-off, off):
                position = (north + x * side, east + y * side, bottom.depth_m + half)
                self._add(shape, 0.0, position)

    def _add(
        self,
        shape: int,
        mass: float,
        position: tuple[float, float, float],
        turn: tuple[float, ...] = (0.0, 0.0, 0.0, 1.0),
    ) -> int:
        bullet = self._bullet
        body: int = bullet.createMultiBody(
            mass, shape, basePosition=position, baseOrientation=turn, physicsClientId=self._client
        )
        self._prepare(body)
        return body

    def _prepare(self, body: int) -> None:
        """Set the properties of all bodies: friction, no restitution, no damping."""
        bullet = self._bullet
        bullet.changeDynamics(
            body,
            -1,
            linearDamping=0.0,  # Bullet's default is 0.04
            angularDamping=0.0,
            lateralFriction=constants.FRICTION.scalar,
            restitution=0.0,
            activationState=bullet.ACTIVATION_STATE_DISABLE_SLEEPING,
            physicsClientId=self._client,
        )

    def _add_hull(self, vehicle: Vehicle) -> int:
        bullet = self._bullet
        # A file in memory, since Bullet only reads files.
        with open(os.memfd_create("urdf"), "w", encoding="utf-8") as file:
            file.write(urdf_of(vehicle))
            file.flush()
            hull: int = bullet.loadURDF(
                f"/proc/self/fd/{file.fileno()}",
                flags=bullet.URDF_USE_INERTIA_FROM_FILE,
                physicsClientId=self._client,
            )
        self._prepare(hull)
        added = np.diag(vehicle.mass_added())
        turned = zip(vehicle.inertia_about_gravity(), added[3:], strict=True)
        bullet.changeDynamics(
            hull,
            -1,
            mass=float(vehicle.mass.scalar + added[:3].min()),
            localInertiaDiagonal=[float(own + water) for own, water in turned],
            physicsClientId=self._client,
        )
        return hull

    def _add_box(self, box: TargetBox) -> int:
        half = [0.5 * s for s in box.size]
        shape = self._bullet.createCollisionShape(
            self._bullet.GEOM_BOX, halfExtents=half, physicsClientId=self._client
        )
        turn = (0.0, 0.0, sin(0.5 * box.yaw), cos(0.5 * box.yaw))
        return self._add(shape, 0.0 if box.fixed else box.mass, box.centre, turn)

    @property
    def impulses(self) -> Array:
        """Return none, (0, 3): Bullet keeps its own."""
        return np.zeros((0, 3))

    def step(self, before: Array, after: Array, step_s: float) -> Array:
        """Return the impulse of all contacts on the hull, like `Contact.impulse`.

        The hull has the pose of the start of the step and the velocity of its end: so has Bullet
        after it applied forces and before it solves contacts.
        """
        bullet, client = self._bullet, self._client
        world_motion(before, after, self._gravity_centre, self._motion)
        motion = self._motion.tolist()
        w, x, y, z = before[3:7].tolist()
        bullet.resetBasePositionAndOrientation(
            self._hull, motion[:3], [x, y, z, w], physicsClientId=client
        )
        bullet.resetBaseVelocity(self._hull, motion[3:6], motion[6:], physicsClientId=client)
        if self._box_moves:
            force, position = [0.0, 0.0, self._box_weight], self.box_pose()[0].tolist()
            bullet.applyExternalForce(
                self._box, -1, force, position, bullet.WORLD_FRAME, physicsClientId=client
            )
        bullet.setTimeStep(step_s, physicsClientId=client)
        bullet.stepSimulation(physicsClientId=client)
        points = bullet.getContactPoints(bodyA=self._hull, physicsClientId=client)
        total = np.zeros(6)
        for point in points:
            normal, along, across = point[7], point[11], point[13]
            force = [
                step_s * (point[9] * n + point[10] * a + point[12] * c)
                for n, a, c in zip(normal, along, across, strict=True)
            ]
            add_impulse_at(before, np.array(point[5]), np.array(force), total)
        return total

    def box_pose(self) -> tuple[Array, Array]:
        """Return position (3,) and quaternion w x y z (4,) of the box."""
        position, (x, y, z, w) = self._bullet.getBasePositionAndOrientation(
            self._box, physicsClientId=self._client
        )
        return np.array(position), np.array([w, x, y, z])

    def box_speed(self) -> float:
        """Return the largest component of the box's velocity [m/s, rad/s]; zero for a fixed one."""
        if not self._box_moves:
            return 0.0
        linear, angular = self._bullet.getBaseVelocity(self._box, physicsClientId=self._client)
        return float(max(abs(value) for value in (*linear, *angular)))

    def close(self) -> None:
        """Disconnect; a second call does nothing."""
        self._close()


@njit(cache=True, error_model="numpy")
def world_motion(before: Array, after: Array, point: Array, out: Array) -> None:
    """Write position, velocity and rates of a point of the body, world frame, to `out`, (9,).

    Position and axes are those of `before`, velocities those of `after`.
    """
    rotation = np.empty((3, 3))
    write_rotation(before[3], before[4], before[5], before[6], rotation)
    p, q, r = after[10], after[11], after[12]
    x, y, z = point[0], point[1], point[2]
    u, v, w = after[7] + q * z - r * y, after[8] + r * x - p * z, after[9] + p * y - q * x
    for i in range(3):
        a, b, c = rotation[i, 0], rotation[i, 1], rotation[i, 2]
        out[i] = before[i] + a * x + b * y + c * z
        out[3 + i] = a * u + b * v + c * w
        out[6 + i] = a * p + b * q + c * r


@njit(cache=True, error_model="numpy")
def add_impulse_at(state: Array, position: Array, impulse: Array, out: Array) -> None:
    """Add an impulse (3,) at a point (3,), world frame, to `out`, (6,) body frame."""
    rotation = np.empty((3, 3))
    write_rotation(state[3], state[4], state[5], state[6], rotation)
    x, y, z = position[0] - state[0], position[1] - state[1], position[2] - state[2]
    torque = (
        y * impulse[2] - z * impulse[1],
        z * impulse[0] - x * impulse[2],
        x * impulse[1] - y * impulse[0],
    )
    for i in range(3):
        for j in range(3):
            out[i] += rotation[j, i] * impulse[j]
            out[3 + i] += rotation[j, i] * torque[j]


def _import_bullet() -> ModuleType:
    """Import PyBullet without the line that it prints to stdout or stderr."""
    library = ctypes.CDLL(None)
    streams = (1, 2)
    saved = [os.dup(stream) for stream in streams]
    devnull = os.open(os.devnull, os.O_WRONLY)
    try:
        library.fflush(None)
        for stream in streams:
            os.dup2(devnull, stream)
        import pybullet  # noqa: PLC0415  # 65 ms and 30 MB that a run without contact saves

        library.fflush(None)  # the line is in the buffer of the C library until then
    finally:
        for stream, old in zip(streams, saved, strict=True):
            os.dup2(old, stream)
            os.close(old)
        os.close(devnull)
    module: ModuleType = pybullet
    return module
