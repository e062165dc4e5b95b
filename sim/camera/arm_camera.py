"""The camera of a vehicle that has an arm, which it sees, and the camera on that arm."""

from collections.abc import Sequence

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.camera.bodies import Bodies, Placed
from seamark.sim.camera.bottom.painter import Tiles
from seamark.sim.camera.camera import Camera, Window
from seamark.sim.camera.effects import Effects
from seamark.sim.camera.link_camera import LinkCamera, downward, lamp_beside
from seamark.sim.camera.optics import VISIBILITY, Optics
from seamark.sim.camera.target import Target
from seamark.sim.camera.water import Water
from seamark.sim.multibody.assembly import Mounting, assemble
from seamark.sim.multibody.posture import Posture
from seamark.sim.multibody.workpiece import Workpiece
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.compilation import SameTypes
from seamark.sim.vehicles import Vehicle

ON_ARM = VISIBILITY  # E: a small camera with the field of view of the vehicle's
_OTHER_NOISE = 0x5DEECE66D  # of the camera on the arm


class _Face:
    """The face of a workpiece that trackers look for."""

    def __init__(self, workpiece: Workpiece, links: Sequence[str]) -> None:
        link, corners = workpiece.face.link, workpiece.corners()
        self._link = None if link is None else links.index(link)
        centre = 0.25 * corners.sum(axis=0)
        self._points = np.vstack([corners, centre, centre])
        self._moved, self._move = self._points.copy(), SameTypes(_write_points)

    def points(self, placed: Placed) -> Array:
        """Return four corners and twice the centre, (6, 3) [m] NED."""
        if self._link is None:
            return self._points
        turn, origin = placed.rotation[self._link], placed.position[self._link]
        self._move.call(turn, origin, self._points, self._moved)
        return self._moved


class ArmCamera(Camera):
    """`Camera` where the vehicle has an arm: an image depends on its joints, too.

    A pose is that of `Posture.place`: of the vehicle with its velocities, of the joints of the
    arm's motors, of the workpiece, whose face then is the target, and of other things.
    """

    def __init__(
        self,
        optics: Optics,
        water: Water,
        target: Target,
        carried: tuple[Vehicle, Mounting],
        *,
        workpiece: Workpiece | None = None,
        noise_seed: int,
        effects: Effects | None = None,
        bottom: Tiles | None = None,
    ) -> None:
        """Set up the cameras of a vehicle and of the arm that it carries.

        `bottom` is a painted seabed instead of the plain one.
        """
        super().__init__(optics, water, target, noise_seed=noise_seed, effects=effects)
        self.workpiece, self.bottom = workpiece, bottom
        vehicle, mounting = carried
        things = () if workpiece is None else workpiece.things
        assembly = assemble(vehicle, [mounting, *things], bottom=False)
        links = [link.name for link in assembly.mechanism.links]
        self._posture = (
            Posture(assembly)
            if workpiece is None
            else Posture(assembly, workpiece.link, workpiece.others)
        )
        self._numbers = b""  # of the pose that the links are at
        self._links: Placed
        self._face = None if workpiece is None else _Face(workpiece, links)
        hull = len(vehicle.drawn())  # which the vehicle's camera has behind it
        standing = target if workpiece is None else None
        bodies = Bodies(assembly.looks[hull:], links, target=standing)
        self._eye = LinkCamera(
            optics,
            water,
            bodies,
            mount=downward(optics),
            seabed_m=target.seabed_m,
            noise_seed=noise_seed,
            effects=effects,
        )
        self._eye.bottom = bottom
        self._on_arm = None
        if assembly.camera is not None:
            self._on_arm = LinkCamera(
                ON_ARM,
                water,
                Bodies(assembly.looks, links, target=standing),
                mount=assembly.camera,
                seabed_m=target.seabed_m,
                noise_seed=noise_seed ^ _OTHER_NOISE,
                lamp=lamp_beside(downward(optics)),
                effects=effects,
            )
            self._on_arm.bottom = bottom

    def colour_on_arm(self, pose: Array, frame: int) -> NDArray[np.uint8] | None:
        """Return a new image (H, W, 3) in blue, green, red; None without a camera on the arm."""
        return None if self._on_arm is None else self._on_arm.colour(self._placed(pose), frame)

    def grey_on_arm(self, pose: Array, frame: int) -> NDArray[np.uint8] | None:
        """Return a new image (H, W): the one that programs get; None without a camera there."""
        return None if self._on_arm is None else self._on_arm.grey(self._placed(pose), frame)

    def follow(self, pose: Array) -> None:
        """Put the target where it is in the image of a pose: on the face of the workpiece."""
        if self._face is not None:
            self._points[:] = self._face.points(self._placed(pose))
            self._corners[:] = self._points[:4]

    def truth(self, pose: Array) -> list[float]:
        """Return what `Camera.truth` does, of where the target is in the image of the pose."""
        self.follow(pose)
        return super().truth(pose)

    def corners(self, pose: Array) -> Array:
        """Return what `Camera.corners` does, of where the target is in the image of the pose."""
        self.follow(pose)
        return super().corners(pose)

    def _placed(self, pose: Array) -> Placed:
        # Both cameras and the target ask for the same pose in one control step.
        numbers = pose.tobytes()
        if numbers != self._numbers:
            self._links, self._numbers = Placed(*self._posture.place(pose)), numbers
        return self._links

    def _draw(
        self, pose: Array, frame: int, window: Window, number: int, out: NDArray[np.uint8]
    ) -> None:
        self._eye.draw(self._placed(pose), frame, window, number, out)


@njit(cache=True, error_model="numpy")
def _write_points(turn: Array, origin: Array, points: Array, out: Array) -> None:
    """Write points, (n, 3) [m], of axes in those that the axes are in."""
    for i in range(len(points)):
        for a in range(3):
            out[i, a] = origin[a]
            for b in range(3):
                out[i, a] += turn[a, b] * points[i, b]
