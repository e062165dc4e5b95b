"""The camera above a pipe on the seabed."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.camera import rows
from seamark.sim.camera.camera import GREEN, Camera, Window
from seamark.sim.camera.geometry import camera_pose
from seamark.sim.camera.optics import Optics
from seamark.sim.camera.pipe_rows import draw_pipe, ground_map, painted
from seamark.sim.camera.raycast import (
    View,
    expose_strip,
    fetch_noise,
    padded_columns,
    view_from,
)
from seamark.sim.camera.scene import MARGIN, STRIP, Buffers, Channel, Scene, SensorNoise
from seamark.sim.camera.target import Target
from seamark.sim.camera.water import Water
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.compilation import SameTypes
from seamark.sim.physics.pipe import Pipe


class PipeCamera(Camera):
    """`Camera` above a pipe, without effects of light; the target is hidden in the pipe."""

    def __init__(
        self, optics: Optics, water: Water, target: Target, pipe: Pipe, *, noise_seed: int
    ) -> None:
        super().__init__(optics, water, target, noise_seed=noise_seed)
        self.pipe = pipe
        self._paints = {GREEN: self._painted(GREEN)}
        self._render_pipe = SameTypes(draw)

    def _painted(self, number: int) -> NDArray[np.float32]:
        paint: NDArray[np.float32] = painted(self.pipe, number)
        return paint

    def _draw(
        self,
        pose: Array,
        frame: int,
        window: Window,
        number: int,
        out: NDArray[np.uint8],
    ) -> None:
        channel = self._channels.get(number)
        if channel is None:
            channel = self._channels[number] = self._build_channel(number)
            self._paints[number] = self._painted(number)
        self._pose[:] = pose[:6]
        self._render_pipe.call(
            *(self._pose, self._scene, channel, self._grain),
            *((self.pipe, self._paints[number]), (frame, window), self._buffers, out),
        )


@njit(cache=True, nogil=True, error_model="numpy")
def draw(
    pose: Array,
    scene: Scene,
    channel: Channel,
    grain: SensorNoise,
    laid: tuple[Pipe, NDArray[np.float32]],
    asked: tuple[int, Window],
    buffers: Buffers,
    out: NDArray[np.uint8],
) -> None:
    """Render a window of one channel into `out` (H, W) uint8; `asked` is its frame and itself.

    `laid` is the pipe, and what `painted` returns for it.
    The water in front of the pipe counts up to the seabed behind it.
    """
    pipe, paint = laid
    frame, (x0, y0, x1, y1) = asked
    view = view_from(pose, scene, channel.attenuation, asked[1])
    rotation, centre = np.empty((3, 3)), np.empty(3)
    camera_pose(pose, scene.mount, rotation, centre)
    ground = ground_map(rotation, centre, scene.intrinsics, pipe.seabed_m)
    start, width = padded_columns(x0, x1)
    height = max(1, STRIP // width)
    for row in range(y0, y1, height):
        light = buffers.light[: min(height, y1 - row) * width]
        extent, noise_key = (row, start, x0, x1), (frame, channel.number)
        fetch_noise(extent, light.shape[0] // width, grain, noise_key)
        _seabed(view, (row, start, width), channel, light)
        draw_pipe(pipe, paint, (ground, centre), (row, start, width), light)
        from_node = (row + MARGIN, start + MARGIN, width)
        rows.attenuate(view.nodes, from_node, channel.veil, light)
        expose_strip(light, extent, grain, noise_key, buffers.levels, out)


@njit(cache=True, nogil=True, error_model="numpy")
def _seabed(
    view: View, extent: tuple[int, int, int], channel: Channel, light: NDArray[np.float32]
) -> None:
    shift = (view.north, view.east)
    rows.seabed_light(channel.seabed, view.ground, extent, shift, light)
