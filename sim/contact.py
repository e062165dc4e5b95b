"""Contacts with the bottom and with the target: PyBullet as an oracle of impulses behind a gate.

The plant moves itself; Bullet only says which impulse contacts give within a step, and is neither
imported nor called while nothing can touch. Bullet knows a scalar mass alone: it gets the rigid
mass plus the smallest translational added mass. Less than the true mass in each direction is
stable (an impulse never overshoots), more is not; the rest converges over the next steps. Only the
impulses at the contact points are taken over, so momentum passes exactly from body to body.

The target has no drag; its weight is that in water.
"""

import ctypes
import os
import weakref
from dataclasses import dataclass
from types import ModuleType

import numpy as np

from sim.elementary import cos, sin
from sim.hydrodynamics import write_rotation
from sim.vehicles import STANDARD_GRAVITY, Array, Vehicle

GATE_M = 0.5  # nothing can touch while the hull's sphere is farther away than this
WATER_DENSITY = 1000.0  # [kg/m³] fresh water, as in the test pool
FRICTION = 0.5  # of hull, target and bottom; E
AWAKE_SPEED = 1e-3  # [m/s, rad/s] a target slower than this lies still


@dataclass(frozen=True, slots=True, kw_only=True)
class LooseBox:
    """A box that can be pushed; the default is the experiment's black box."""

    centre: tuple[float, float, float]  # [m] NED
    yaw: float = 0.0  # [rad]
    size: tuple[float, float, float] = (0.42, 0.13, 0.13)  # [m] S, S: UWSim; height E
    mass: float = 15.0  # [kg] S: UWSim cirs.xml


class Contact:
    """A flat bottom, maybe a box on it, and the vehicle's hull. Close it after use.

    Parameters
    ----------
    seabed_z : float
        Depth of the bottom [m].
    """

    def __init__(self, vehicle: Vehicle, *, seabed_z: float, box: LooseBox | None = None) -> None:
        top = seabed_z
        if box is not None:
            top = min(top, box.centre[2] - 0.5 * box.size[2])
        self.gate_depth = top - GATE_M - vehicle.hull_radius()
        self.awake = False
        self._vehicle = vehicle
        self._seabed_z = seabed_z
        self._box = box
        self._world: _World | None = None

    def impulse(self, before: Array, after: Array, step_s: float) -> Array:
        """Return what contacts give within one step.

        Parameters
        ----------
        before, after : (13 + n,)
            The plant's state at the start of the step, and at its end if nothing touches.

        Returns
        -------
        (6,) [N s, N m s]
            About the origin, in the body frame of `before`.
        """
        if self._world is None:
            self._world = _World(self._vehicle, self._seabed_z, self._box)
        push = self._world.step(before, after, step_s)
        self.awake = self._world.box_speed() > AWAKE_SPEED
        return push

    def box_pose(self) -> tuple[Array, Array]:
        """Return position (3,) [m] and quaternion w x y z (4,) of the box now.

        Raises
        ------
        LookupError
            When there is no box.
        """
        if self._box is None:
            raise LookupError("there is no box")
        if self._world is None:
            half = 0.5 * self._box.yaw
            return np.array(self._box.centre), np.array([cos(half), 0.0, 0.0, sin(half)])
        return self._world.box_pose()

    def close(self) -> None:
        """Disconnect from Bullet, if it was ever needed."""
        if self._world is not None:
            self._world.close()
            self._world = None


class _World:
    """One PyBullet world of its own: bottom, hull, box."""

    def __init__(self, vehicle: Vehicle, seabed_z: float, box: LooseBox | None) -> None:
        bullet = _import_bullet()
        self._bullet = bullet
        self._client = bullet.connect(bullet.DIRECT)
        self._close = weakref.finalize(self, bullet.disconnect, self._client)
        self._gravity_centre = np.array(vehicle.centre_of_gravity.value)
        self._rotation = np.empty((3, 3))
        bullet.setPhysicsEngineParameter(
            deterministicOverlappingPairs=1, numSolverIterations=100, physicsClientId=self._client
        )
        # No gravity: weight and buoyancy of the vehicle are the plant's business.
        bullet.setGravity(0, 0, 0, physicsClientId=self._client)
        plane = bullet.createCollisionShape(
            bullet.GEOM_PLANE, planeNormal=[0, 0, -1], physicsClientId=self._client
        )
        self._add(plane, 0.0, (0.0, 0.0, seabed_z))
        self._hull = self._add_hull(vehicle)
        self._box = None if box is None else self._add_box(box)
        self._box_weight = 0.0
        if box is not None:
            displaced = WATER_DENSITY * box.size[0] * box.size[1] * box.size[2]
            self._box_weight = (box.mass - displaced) * STANDARD_GRAVITY

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
        bullet.changeDynamics(
            body,
            -1,
            linearDamping=0.0,  # 0.04 unless told otherwise
            angularDamping=0.0,
            lateralFriction=FRICTION,
            restitution=0.0,
            activationState=bullet.ACTIVATION_STATE_DISABLE_SLEEPING,
            physicsClientId=self._client,
        )
        return body

    def _add_hull(self, vehicle: Vehicle) -> int:
        bullet, gravity = self._bullet, vehicle.centre_of_gravity.value
        centres = [
            [c - g for c, g in zip(piece.centre.value, gravity, strict=True)]
            for piece in vehicle.hull
        ]
        count = len(vehicle.hull)
        shape = bullet.createCollisionShapeArray(
            shapeTypes=[bullet.GEOM_BOX] * count,
            halfExtents=[[0.5 * s for s in piece.size.value] for piece in vehicle.hull],
            collisionFramePositions=centres,
            collisionFrameOrientations=[[0, 0, 0, 1]] * count,
            physicsClientId=self._client,
        )
        rigid, added = np.diag(vehicle.mass_rigid()), np.diag(vehicle.mass_added())
        hull = self._add(shape, float(rigid[0] + added[:3].min()), (0.0, 0.0, 0.0))
        bullet.changeDynamics(
            hull,
            -1,
            localInertiaDiagonal=[float(a + b) for a, b in zip(rigid[3:], added[3:], strict=True)],
            physicsClientId=self._client,
        )
        return hull

    def _add_box(self, box: LooseBox) -> int:
        half = [0.5 * s for s in box.size]
        shape = self._bullet.createCollisionShape(
            self._bullet.GEOM_BOX, halfExtents=half, physicsClientId=self._client
        )
        turn = (0.0, 0.0, sin(0.5 * box.yaw), cos(0.5 * box.yaw))
        return self._add(shape, box.mass, box.centre, turn)

    def step(self, before: Array, after: Array, step_s: float) -> Array:
        """Return the impulse of all contacts on the hull, as `Contact.impulse`.

        The hull stands where the step began and has the velocity it would have at its end: that is
        what Bullet makes of forces before it solves contacts.
        """
        bullet, client = self._bullet, self._client
        w, x, y, z = (float(value) for value in before[3:7])
        write_rotation(w, x, y, z, self._rotation)
        turned = self._to_world
        origin = before[:3]
        linear = after[7:10] + np.cross(after[10:13], self._gravity_centre)
        bullet.resetBasePositionAndOrientation(
            self._hull,
            (origin + turned(self._gravity_centre)).tolist(),
            [x, y, z, w],
            physicsClientId=client,
        )
        bullet.resetBaseVelocity(
            self._hull,
            turned(linear).tolist(),
            turned(after[10:13]).tolist(),
            physicsClientId=client,
        )
        if self._box is not None:
            force, place = [0.0, 0.0, self._box_weight], self.box_pose()[0].tolist()
            bullet.applyExternalForce(
                self._box, -1, force, place, bullet.WORLD_FRAME, physicsClientId=client
            )
        bullet.setTimeStep(step_s, physicsClientId=client)
        bullet.stepSimulation(physicsClientId=client)
        return self._contact_impulse(origin, step_s)

    def _contact_impulse(self, origin: Array, step_s: float) -> Array:
        push = np.zeros(6)
        points = self._bullet.getContactPoints(bodyA=self._hull, physicsClientId=self._client)
        for point in points:
            place, normal = np.array(point[5]), np.array(point[7])
            force = point[9] * normal + point[10] * np.array(point[11])
            force = (force + point[12] * np.array(point[13])) * step_s
            push[:3] += self._to_body(force)
            push[3:] += self._to_body(np.cross(place - origin, force))
        return push

    def _to_world(self, vector: Array) -> Array:
        r = self._rotation
        turned: Array = r[:, 0] * vector[0] + r[:, 1] * vector[1] + r[:, 2] * vector[2]
        return turned

    def _to_body(self, vector: Array) -> Array:
        r = self._rotation
        turned: Array = r[0] * vector[0] + r[1] * vector[1] + r[2] * vector[2]
        return turned

    def box_pose(self) -> tuple[Array, Array]:
        """Return position (3,) and quaternion w x y z (4,) of the box."""
        place, (x, y, z, w) = self._bullet.getBasePositionAndOrientation(
            self._box, physicsClientId=self._client
        )
        return np.array(place), np.array([w, x, y, z])

    def box_speed(self) -> float:
        """Return the largest component of the box's velocity [m/s, rad/s], zero without a box."""
        if self._box is None:
            return 0.0
        linear, angular = self._bullet.getBaseVelocity(self._box, physicsClientId=self._client)
        return float(max(abs(value) for value in (*linear, *angular)))

    def close(self) -> None:
        """Disconnect; a second call does nothing."""
        self._close()


def _import_bullet() -> ModuleType:
    """Import PyBullet without the line that it prints: standard output belongs to the caller."""
    library = ctypes.CDLL(None)
    kept = os.dup(1)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        library.fflush(None)
        os.dup2(nowhere, 1)
        import pybullet  # noqa: PLC0415  # 65 ms and 30 MB that a free run does not pay

        library.fflush(None)  # the line is in the C library's buffer until then
    finally:
        os.dup2(kept, 1)
        os.close(kept)
        os.close(nowhere)
    module: ModuleType = pybullet
    return module
