"""The camera: an image is a pure function of pose, water, noise seed and frame number."""

from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from seamark.sim.camera import pictures, raycast, raycast_effects
from seamark.sim.camera.caustics import WAVES, draw_waves, wave_amplitude
from seamark.sim.camera.effects import EffectParameters, Effects
from seamark.sim.camera.geometry import camera_pose, project
from seamark.sim.camera.optics import Optics
from seamark.sim.camera.pencil import Pencil
from seamark.sim.camera.rows import CHUNK, interleave
from seamark.sim.camera.scene import Channel, Scene, SensorNoise, buffers_for
from seamark.sim.camera.seabed import SEABED_SEED, seabed
from seamark.sim.camera.survey import Survey, survey
from seamark.sim.camera.target import Target, box_texture
from seamark.sim.camera.water import Water
from seamark.sim.numerics.compilation import SameTypes
from seamark.sim.numerics.libm import cos, sin
from seamark.sim.numerics.normals import normals

Window = raycast.Window
GREEN = 1
SAND = "sand"


@lru_cache(maxsize=4)
def noise_bank(seed: int, width: int) -> NDArray[np.float32]:
    """Return standard normal samples; the first `width` are repeated at the end for long rows."""
    once = raycast.NOISE_LENGTH
    bank = np.empty(once + width + CHUNK, np.float32)
    normals(seed, bank[:once])
    bank[once:] = bank[: width + CHUNK]
    return bank


def sensor_noise(water: Water, noise_seed: int, width: int) -> SensorNoise:
    """Return the noise of a camera with images of this width [px]."""
    seed = noise_seed & 0x7FFFFFFFFFFFFFFF  # int64, so one compilation
    return SensorNoise(
        bank=noise_bank(seed, width),
        seed=seed,
        read_variance=float(water.read_sigma_grey) ** 2,
        shot_gain=float(water.shot_gain),
    )


def effect_parameters(effects: Effects, noise_seed: int) -> EffectParameters:
    """Return the effects for the kernels."""
    seed = noise_seed & 0x7FFFFFFF
    sine, cosine = sin(effects.lamp_cone_rad), cos(effects.lamp_cone_rad)
    return EffectParameters(
        exposure_s=float(effects.exposure_s),
        level=float(effects.light_level),
        waves=draw_waves(seed)[: WAVES if effects.caustics > 0 else 0],
        wave=wave_amplitude(effects.caustics),
        lamp=float(effects.lamp),
        cone=(cosine / sine) ** 2,
        alters_light=effects.alters_light,
        snow=float(effects.snow_per_m3),
        scatter=float(effects.scatter_rad),
        fish=effects.fish_per_min / 60.0,
        fish_m=float(effects.fish_length_m),
        frame_s=float(effects.frame_s),
        seed=seed,
        drift=np.zeros(5),
    )


class Camera:
    """Renders what the vehicle's camera sees, and knows the target's true position in the image.

    The grey image is the green channel of the colour image, noise included. A pose is (6,) north,
    east, down [m], roll, pitch, yaw [rad]; for motion blur the body-frame velocities u, v, w [m/s]
    and p, q, r [rad/s] follow, (12,).
    """

    def __init__(
        self,
        optics: Optics,
        water: Water,
        target: Target,
        *,
        noise_seed: int,
        effects: Effects | None = None,
        ground: str = SAND,
    ) -> None:
        self.ground = ground  # SAND, or one of `pictures.PICTURES`
        self.optics, self.water, self.target = optics, water, target
        self.effects = effects or Effects()
        self._lens = (optics.intrinsics(), np.array(optics.mount_m))
        self._faces = target.faces()
        self._corners = target.top_corners()
        self._points = np.concatenate(
            [self._corners, target.top_centre()[None], target.origin()[None]]
        )
        self._images = np.empty((len(self._points), 2))
        self._scene = self._build_scene()
        self._noise_seed = noise_seed
        self._has_effects = self.effects.any
        self._buffers = buffers_for(optics.width)
        self._channels = {GREEN: self._build_channel(GREEN)}
        self._whole = (0, 0, optics.width, optics.height)
        self._canvas = np.zeros((optics.height, optics.width), np.uint8)
        self._rotation, self._position, self._pose = np.empty((3, 3)), np.empty(3), np.zeros(6)
        self._motion = np.zeros(12)
        self._render = SameTypes(raycast.draw)
        self._render_effects = SameTypes(raycast_effects.draw)

    @cached_property
    def _effect_parameters(self) -> EffectParameters:
        return effect_parameters(self.effects, self._noise_seed)

    @cached_property
    def _grain(self) -> SensorNoise:
        """Its noise, which takes two milliseconds: many cameras are asked for corners alone."""
        return sensor_noise(self.water, self._noise_seed, self.optics.width)

    def at(self, motion: NDArray[np.float64], frame: int) -> NDArray[np.float64]:
        """Return the pose that the other methods take: with all that moves beside the vehicle.

        Here nothing does.
        """
        return motion

    def target_at(self, pose: NDArray[np.float64]) -> Target:
        """Return the target where it is in the image of a pose; here it does not move."""
        return self.target

    def follow(self, pose: NDArray[np.float64]) -> None:
        """Put the target where it is in the image of a pose; here it does not move."""

    def region(self, pose: NDArray[np.float64], frame: int, window: Window) -> NDArray[np.uint8]:
        """Return the camera's canvas (H, W), rendered only inside the window x0, y0, x1, y1.

        The pixels are those of `grey`, byte for byte. The canvas is valid until the next call.
        """
        x0, y0, x1, y1 = inside = window
        _, _, width, height = self._whole
        if x0 < 0 or y0 < 0 or x1 > width or y1 > height:
            inside = (max(0, x0), max(0, y0), min(width, x1), min(height, y1))
        if inside[2] > inside[0] and inside[3] > inside[1]:
            self._draw(pose, frame, inside, GREEN, self._canvas)
        return self._canvas

    def grey(self, pose: NDArray[np.float64], frame: int) -> NDArray[np.uint8]:
        """Return a new image (H, W): the one that trackers get."""
        image = np.empty_like(self._canvas)
        self._draw(pose, frame, self._whole, GREEN, image)
        return image

    def colour(self, pose: NDArray[np.float64], frame: int) -> NDArray[np.uint8]:
        """Return a new image (H, W, 3) in blue, green, red, for people."""
        planes = [np.empty_like(self._canvas) for _ in range(3)]
        for channel, plane in enumerate(planes):
            self._draw(pose, frame, self._whole, channel, plane)
        image = np.empty((*self._canvas.shape, 3), np.uint8)
        red, green, blue = (plane.ravel() for plane in planes)
        interleave(blue, green, red, image.ravel())
        return image

    def survey(self, pose: NDArray[np.float64]) -> Survey:
        """Return depth and label of each pixel, without water."""
        out = Survey(np.empty(self._canvas.shape, np.float32), np.empty_like(self._canvas))
        self._pose[:] = pose[:6]
        survey(self._pose, self._scene, out)
        return out

    def top_corners(self, pose: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return where the top face's corners are, (4, 3) [m] NED, in the order of `corners`."""
        self.follow(pose)
        return self._points[:4].copy()

    def corners(self, pose: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the image points (4, 2) [px] of the top face's corners; NaN behind the camera.

        In reading order of the letters: upper left, upper right, lower right, lower left.
        """
        return self._project(pose, self._corners)

    def position(self, pose: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the position of the camera, (3,) [m] NED."""
        self._pose[:] = pose[:6]
        camera_pose(self._pose, self._lens[1], self._rotation, self._position)
        return self._position.copy()

    def view(self) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Return the target's points of `truth`, (6, 3) [m], intrinsics and mount, for kernels."""
        return self._points, *self._lens

    def truth(self, pose: NDArray[np.float64]) -> list[float]:
        """Return corners (8), centroid (2), origin (2) [px] and the camera's position (3) [m].

        The centroid is that of the top face, the origin that of the box: UWSim's convention. Seen
        obliquely the origin is not at the centre of the visible face; for a perfect tracker this
        parallax is a bias of a few pixels.
        """
        self._pose[:] = pose[:6]
        camera_pose(self._pose, self._lens[1], self._rotation, self._position)
        project(self._points, self._rotation, self._position, self._lens[0], self._images)
        images: list[float] = self._images.ravel().tolist()
        return images + self._position.tolist()

    def _project(
        self, pose: NDArray[np.float64], points: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        out = np.empty((len(points), 2))
        self._pose[:] = pose[:6]
        camera_pose(self._pose, self._lens[1], self._rotation, self._position)
        project(points, self._rotation, self._position, self._lens[0], out)
        return out

    def pencil(self, number: int = GREEN) -> Pencil:
        """Return what a compiled loop over many cameras draws a channel of this one with.

        The camera keeps all its arrays.
        """
        return Pencil(
            *(self._scene, self._channel(number), self._grain, self._effect_parameters),
            altered=self._has_effects,
        )

    def _channel(self, number: int) -> Channel:
        channel = self._channels.get(number)
        if channel is None:
            channel = self._channels[number] = self._build_channel(number)
        return channel

    def _build_scene(self) -> Scene:
        """Return the part of the scene that all channels share."""
        target = self.target
        layout = box_texture(target, GREEN).layout
        return Scene(
            intrinsics=self._lens[0],
            mount=self._lens[1],
            seabed_m=float(target.seabed_m),
            faces=self._faces,
            layout=layout,
            fog=self.water.law == "uwsim",
        )

    def _build_channel(self, number: int) -> Channel:
        """Return the part of the scene that belongs to one colour channel."""
        water, target = self.water, self.target
        return Channel(
            seabed=seabed(SEABED_SEED, number)
            if self.ground == SAND
            else pictures.seabed(self.ground),
            box_texture=box_texture(target, number).texels,
            attenuation=float(water.attenuation[number]),
            veil=255.0 * water.veil[number],
            number=number,
        )

    def _draw(
        self,
        pose: NDArray[np.float64],
        frame: int,
        window: Window,
        number: int,
        out: NDArray[np.uint8],
    ) -> None:
        channel = self._channel(number)
        # A copy, of the type that is compiled for: a pose may be read-only or strided.
        self._motion[6:] = 0.0
        self._motion[: len(pose)] = pose
        self._pose[:] = pose[:6]
        scene, grain = self._scene, self._grain
        if not self._has_effects:
            self._render.call(self._pose, scene, channel, grain, frame, window, self._buffers, out)
            return
        self._render_effects.call(
            *(self._motion, scene, channel, grain, self._effect_parameters),
            *((frame, window), self._buffers, out),
        )
