"""The camera above a painted bottom."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from seamark.sim.camera.bottom.bottom import STRIP_M, Bottom
from seamark.sim.camera.camera import Camera
from seamark.sim.camera.effects import Effects
from seamark.sim.camera.geometry import camera_pose
from seamark.sim.camera.optics import Optics
from seamark.sim.camera.scene import Channel, Scene
from seamark.sim.camera.target import Target
from seamark.sim.camera.water import Water
from seamark.sim.numerics.libm import atan2

_STEEPEST = 0.2  # cosine of the largest tilt at which the middle of the image is looked for
_NO_TEXTURE = np.zeros(1, np.uint16)


class Seen(NamedTuple):
    """A thing as it is seen from a pose."""

    name: str
    corners: NDArray[np.float64]  # (4, 2) [px] of its plan rectangle; NaN behind the camera
    uncovered: float  # share of it that nothing lies on
    distance: float  # [m] of the camera from its centre
    angle: float  # [rad] between the line of sight and the normal of the bottom


class BottomCamera(Camera):
    """A camera whose seabed is a painted bottom, without the box that others see."""

    def __init__(
        self,
        optics: Optics,
        water: Water,
        bottom: Bottom,
        *,
        noise_seed: int,
        effects: Effects | None = None,
    ) -> None:
        self.bottom = bottom
        super().__init__(
            optics, water, Target(), noise_seed=noise_seed, effects=effects, ground=bottom.ground
        )

    def seen(self, pose: NDArray[np.float64]) -> list[Seen]:
        """Return where each thing is from a pose (6,), objects first, as `NAMES`.

        The bottom repeats itself: of all copies it is the one nearest to the middle of the image.
        """
        axes, position = np.empty((3, 3)), np.empty(3)
        camera_pose(np.array(pose[:6]), self._lens[1], axes, position)
        depth = self.target.seabed_m - position[2]
        middle = position + axes[2] * (depth / max(float(axes[2, 2]), _STEEPEST))
        things = (*self.bottom.objects, *self.bottom.decoys)
        whole = np.array([thing.corners(self.target.seabed_m) for thing in things])  # (n, 4, 3)
        centres = whole.mean(axis=1)
        shift = STRIP_M * np.round((middle - centres)[:, :2] / STRIP_M)
        whole[:, :, :2] += shift[:, None]
        points = self._project(pose, whole.reshape(-1, 3)).reshape(-1, 4, 2)
        centres[:, :2] += shift
        aside = np.sqrt((centres[:, 0] - position[0]) ** 2 + (centres[:, 1] - position[1]) ** 2)
        distances = np.sqrt(aside * aside + depth * depth).tolist()
        angles = [atan2(one, depth) for one in aside.tolist()]
        return [
            Seen(thing.name, *each)
            for thing, *each in zip(
                things, points, self.bottom.visible, distances, angles, strict=True
            )
        ]

    def _build_scene(self) -> Scene:
        return Scene(
            intrinsics=self._lens[0],
            mount=self._lens[1],
            seabed_m=float(self.target.seabed_m),
            faces=np.zeros((0, 12)),
            layout=np.zeros((0, 3), np.int32),
            fog=self.water.law == "uwsim",
        )

    def _build_channel(self, number: int) -> Channel:
        return Channel(
            seabed=self.bottom.packed(number),
            box_texture=_NO_TEXTURE,
            attenuation=float(self.water.attenuation[number]),
            veil=255.0 * self.water.veil[number],
            number=number,
        )
