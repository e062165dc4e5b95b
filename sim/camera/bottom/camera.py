"""The camera above a painted bottom."""

import numpy as np
from numpy.typing import NDArray

from seamark.sim.camera.bottom.bottom import Bottom
from seamark.sim.camera.camera import Camera
from seamark.sim.camera.effects import Effects
from seamark.sim.camera.geometry import camera_pose
from seamark.sim.camera.optics import Optics
from seamark.sim.camera.scene import Channel, Scene
from seamark.sim.camera.target import Target
from seamark.sim.camera.water import Water

_NO_TEXTURE = np.zeros(1, np.int32)


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

    def sight(self, pose: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return rotation (3, 3), world from camera, and position (3,) [m] of the camera."""
        rotation, position = np.empty((3, 3)), np.empty(3)
        camera_pose(np.array(pose[:6]), self._lens[1], rotation, position)
        return rotation, position

    def image_points(
        self, pose: NDArray[np.float64], points: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return where points (n, 3) [m] are in the image, (n, 2) [px]; NaN behind the camera."""
        return self._project(pose, points)

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
