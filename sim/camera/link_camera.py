"""A camera on a link of a mechanism: it looks anywhere and sees the bodies of other links."""

from functools import cache, cached_property

import numpy as np
from numpy.typing import NDArray

from seamark.sim.camera import link_effects, link_raycast
from seamark.sim.camera.bodies import Bodies, Placed
from seamark.sim.camera.body_rows import layers_for
from seamark.sim.camera.bottom.painter import Tiles, packed_tile
from seamark.sim.camera.camera import (
    GREEN,
    Window,
    effect_parameters,
    sensor_noise,
)
from seamark.sim.camera.effects import LAMP_FORWARD_M, Effects
from seamark.sim.camera.geometry import project
from seamark.sim.camera.instant import Mount, Stage, Tones, axes_of, instant_at
from seamark.sim.camera.link_raycast import Memory
from seamark.sim.camera.optics import Optics
from seamark.sim.camera.rows import interleave
from seamark.sim.camera.scene import Channel, Scene, SensorNoise, buffers_for
from seamark.sim.camera.seabed import SEABED_SEED, seabed, texels
from seamark.sim.camera.visibility import mark_shown
from seamark.sim.camera.water import Water
from seamark.sim.multibody.assembly import VEHICLE, Frame
from seamark.sim.numerics.arrays import Array, Flags
from seamark.sim.numerics.compilation import SameTypes

# Turns the axes of a camera that looks down, its image up ahead, to those of the vehicle.
DOWNWARDS = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])


def downward(optics: Optics) -> Frame:
    """Return where `Camera` has its camera: on the vehicle, looking down."""
    return Frame(VEHICLE, np.array(optics.mount_m), DOWNWARDS)


def lamp_beside(camera: Frame) -> Frame:
    """Return where the lamp of `Camera` is: towards the upper edge of the image."""
    return Frame(camera.link, camera.point - LAMP_FORWARD_M * camera.turn[:, 2], camera.turn)


@cache  # each level has cameras of its own
def _mean_of_seabed(number: int) -> float:
    """Return the mean of the seabed's texture in one colour channel [grey]."""
    return _mean_of(texels(SEABED_SEED, number))


def _mean_of(tile: NDArray[np.uint8]) -> float:
    return int(tile.sum(dtype=np.int64)) / tile.size


class LinkCamera:
    """Renders what a camera on a link sees; an image is a pure function of `Placed` and the frame.

    The camera looks along the x axis of `mount`, image right is its y axis and image down its z
    axis. The lamp of the effects shines along the x axis of `lamp`, else beside the camera.
    """

    def __init__(
        self,
        optics: Optics,
        water: Water,
        bodies: Bodies,
        *,
        mount: Frame,
        seabed_m: float,
        noise_seed: int,
        lamp: Frame | None = None,
        effects: Effects | None = None,
    ) -> None:
        self.optics, self.water, self.bodies = optics, water, bodies
        self.effects = effects or Effects()
        self.bottom: Tiles | None = None  # a painted seabed; set before the first image
        if self.effects.fish_per_min > 0:
            raise ValueError("fish swim before the target's camera only: fish_per_min must be 0")
        self._stage = Stage(
            scene=Scene(
                intrinsics=optics.intrinsics(),
                mount=np.zeros(3),
                seabed_m=float(seabed_m),
                faces=np.zeros((0, 12)),
                layout=np.zeros((0, 3), np.int32),
                fog=water.law == "uwsim",
            ),
            shapes=bodies.shapes,
            camera=self._mounted(mount),
            lamp=self._mounted(lamp or lamp_beside(mount)),
        )
        self._noise_seed = noise_seed
        self._effects = effect_parameters(self.effects, noise_seed)
        self._memory = Memory(buffers_for(optics.width), layers_for(optics.width))
        self._channels: dict[int, Tones] = {}
        self._whole = (0, 0, optics.width, optics.height)
        self._canvas = np.zeros((optics.height, optics.width), np.uint8)
        count = len(bodies.links)
        self._placed = np.zeros((count, 3, 3)), np.zeros((count, 3)), np.zeros((count, 6))
        self._render = SameTypes(link_effects.draw if self.effects.any else link_raycast.draw)

    @cached_property
    def _grain(self) -> SensorNoise:
        """Its noise, which takes two milliseconds: many cameras are asked for corners alone."""
        return sensor_noise(self.water, self._noise_seed, self.optics.width)

    def region(self, placed: Placed, frame: int, window: Window) -> NDArray[np.uint8]:
        """Return the camera's canvas (H, W), rendered only inside the window x0, y0, x1, y1.

        The pixels are those of `grey`, byte for byte. The canvas is valid until the next call.
        """
        x0, y0, x1, y1 = window
        _, _, width, height = self._whole
        inside = max(0, x0), max(0, y0), min(width, x1), min(height, y1)
        if inside[2] > inside[0] and inside[3] > inside[1]:
            self.draw(placed, frame, inside, GREEN, self._canvas)
        return self._canvas

    def grey(self, placed: Placed, frame: int) -> NDArray[np.uint8]:
        """Return a new image (H, W): the one that programs get."""
        image = np.empty_like(self._canvas)
        self.draw(placed, frame, self._whole, GREEN, image)
        return image

    def colour(self, placed: Placed, frame: int) -> NDArray[np.uint8]:
        """Return a new image (H, W, 3) in blue, green, red, for people."""
        planes = [np.empty_like(self._canvas) for _ in range(3)]
        for channel, plane in enumerate(planes):
            self.draw(placed, frame, self._whole, channel, plane)
        image = np.empty((*self._canvas.shape, 3), np.uint8)
        red, green, blue = (plane.ravel() for plane in planes)
        interleave(blue, green, red, image.ravel())
        return image

    def project(self, placed: Placed, points: Array) -> Array:
        """Return the image points (n, 2) [px] of points (n, 3) [m] NED; NaN behind the camera."""
        self._place(placed)
        sight = axes_of(self._placed, self._stage.camera)
        out = np.empty((len(points), 2))
        intrinsics = self._stage.scene.intrinsics
        project(np.array(points, dtype=np.float64), sight.axes, sight.centre, intrinsics, out)
        return out

    def shown(self, placed: Placed, points: Array, *, margin_m: float = 0.005) -> Flags:
        """Return which points (n, 3) [m] NED are in the image and hidden by nothing, (n,).

        Water is not considered. What is less than the margin before a point does not hide it, so
        that points on the surface of a body are shown.
        """
        self._place(placed)
        width, height = self._whole[2:]
        tones, stage = self._tones(GREEN), self._stage
        instant = instant_at(self._placed, stage, tones, self._effects, self._whole, 0.0)
        shown = np.zeros(len(points), np.bool_)
        world = np.array(points, dtype=np.float64)
        mark_shown(instant, world, (width, height), stage.scene.seabed_m, margin_m, shown)
        return shown

    def _mounted(self, attached: Frame) -> Mount:
        return Mount(
            self.bodies.number(attached.link),
            np.array(attached.point, dtype=np.float64),
            np.array(attached.turn, dtype=np.float64),
        )

    def _place(self, placed: Placed) -> None:
        """Copy where the links are to arrays of the types that are compiled for."""
        for mine, given in zip(self._placed, placed, strict=True):
            mine[:] = given

    def _tones(self, number: int) -> Tones:
        """Return what belongs to one colour channel."""
        if number not in self._channels:
            water, painted = self.water, self.bottom
            self._channels[number] = Tones(
                channel=Channel(
                    seabed=seabed(SEABED_SEED, number)
                    if painted is None
                    else packed_tile(painted[number]),
                    box_texture=np.zeros(1, np.uint16),
                    attenuation=float(water.attenuation[number]),
                    veil=255.0 * water.veil[number],
                    number=number,
                ),
                paints=self.bodies.paints(number),
                mean=_mean_of_seabed(number) if painted is None else _mean_of(painted[number]),
            )
        return self._channels[number]

    def draw(
        self, placed: Placed, frame: int, window: Window, number: int, out: NDArray[np.uint8]
    ) -> None:
        """Render the window of one channel, 0 red, 1 green, 2 blue, into `out`, (H, W)."""
        self._place(placed)
        stage, tones, grain = self._stage, self._tones(number), self._grain
        effects, key, memory = self._effects, (frame, window), self._memory
        self._render.call(self._placed, stage, tones, grain, effects, key, memory, out)
