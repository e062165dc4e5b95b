"""The camera: pictures as a pure function of pose, water, noise seed and frame number."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from seamark.sim.camera import raycast, special
from seamark.sim.camera.caustics import WAVES, amplitude_for, waves_of
from seamark.sim.camera.effects import Disturbance, Effects
from seamark.sim.camera.geometry import camera_pose, project
from seamark.sim.camera.optics import Optics
from seamark.sim.camera.rows import CHUNK, interleave
from seamark.sim.camera.scene import Channel, Grain, Scene, work_for
from seamark.sim.camera.seabed import seabed
from seamark.sim.camera.target import Target, skin
from seamark.sim.camera.water import Water
from seamark.sim.numerics.libm import cos, sin

Window = raycast.Window
GREEN = 1
SEABED_SEED = 7  # the same sea floor in all runs: a trial's luck is not in its pebbles


@lru_cache(maxsize=4)
def _noise_bank(seed: int, width: int) -> NDArray[np.float32]:
    """Return standard normal samples; the first `width` follow again at the end for long rows."""
    generator = np.random.Generator(np.random.PCG64(seed))
    bank = generator.standard_normal(raycast.NOISE_LENGTH, dtype=np.float32)
    return np.concatenate([bank, bank[: width + CHUNK]])


class Camera:
    """Draws what the vehicle's camera sees, and knows where the target truly is in the picture.

    The grey picture is the green channel of the coloured one, noise included. A pose is (6,) north,
    east, down [m], roll, pitch, yaw [rad]; for motion blur the body's velocities u, v, w [m/s] and
    p, q, r [rad/s] follow, (12,).
    """

    def __init__(
        self,
        optics: Optics,
        water: Water,
        target: Target,
        *,
        noise_seed: int,
        effects: Effects | None = None,
    ) -> None:
        self.optics, self.water, self.target = optics, water, target
        self.effects = effects or Effects()
        self._noise_seed = noise_seed & 0x7FFFFFFFFFFFFFFF  # one integer type, so one compilation
        self._noise = _noise_bank(self._noise_seed, optics.width)
        self._lens = (optics.intrinsics(), np.array(optics.mount_m))
        self._faces = target.faces()
        self._corners = target.top_corners()
        self._centre = target.top_centre()[None]
        self._origin = target.origin()[None]
        self._points = np.concatenate([self._corners, self._centre, self._origin])
        self._images = np.empty((len(self._points), 2))
        self._scene = tuple(self._scene_of())
        self._grain = tuple(
            Grain(
                self._noise,
                self._noise_seed,
                float(water.read_sigma_grey) ** 2,
                float(water.shot_gain),
            )
        )
        self._disturbance = self._disturbance_of()
        self._work = tuple(work_for(optics.width))
        self._channels = {GREEN: tuple(self._channel(GREEN))}
        self._whole = (0, 0, optics.width, optics.height)
        self._canvas = np.zeros((optics.height, optics.width), np.uint8)
        self._rotation, self._place, self._pose = np.empty((3, 3)), np.empty(3), np.empty(6)
        self._motion = np.zeros(12)

    def region(self, pose: NDArray[np.float64], frame: int, window: Window) -> NDArray[np.uint8]:
        """Return the camera's own canvas (H, W), drawn inside the window x0, y0, x1, y1 alone.

        Its pixels are those of `grey`, byte for byte. The canvas is valid until the next call.
        """
        x0, y0, x1, y1 = inside = window
        _, _, width, height = self._whole
        if x0 < 0 or y0 < 0 or x1 > width or y1 > height:
            inside = (max(0, x0), max(0, y0), min(width, x1), min(height, y1))
        if inside[2] > inside[0] and inside[3] > inside[1]:
            self._draw(pose, frame, inside, GREEN, self._canvas)
        return self._canvas

    def grey(self, pose: NDArray[np.float64], frame: int) -> NDArray[np.uint8]:
        """Return a new picture (H, W): the one the trackers work on."""
        picture = np.empty_like(self._canvas)
        self._draw(pose, frame, self._whole, GREEN, picture)
        return picture

    def colour(self, pose: NDArray[np.float64], frame: int) -> NDArray[np.uint8]:
        """Return a new picture (H, W, 3) in blue, green, red, for people."""
        planes = [np.empty_like(self._canvas) for _ in range(3)]
        for channel, plane in enumerate(planes):
            self._draw(pose, frame, self._whole, channel, plane)
        picture = np.empty((*self._canvas.shape, 3), np.uint8)
        red, green, blue = (plane.ravel() for plane in planes)
        interleave(blue, green, red, picture.ravel())
        return picture

    def corners(self, pose: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the image (4, 2) [px] of the top face's corners; NaN if behind the camera.

        In reading order of the letters: upper left, upper right, lower right, lower left.
        """
        return self._project(pose, self._corners)

    def centroid(self, pose: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the image (2,) [px] of the top face's centre: where the diagonals cross."""
        centre: NDArray[np.float64] = self._project(pose, self._centre)[0]
        return centre

    def origin(self, pose: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the image (2,) [px] of the box's middle: UWSim's convention for the truth.

        Seen obliquely it is not the centre of the visible face; that parallax is a bias of some
        pixels for a perfect tracker.
        """
        origin: NDArray[np.float64] = self._project(pose, self._origin)[0]
        return origin

    def position(self, pose: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the position of the camera, (3,) [m] NED."""
        return np.array(self.truth(pose)[-3:])

    def view(self) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Return the target's points of `truth`, (6, 3) [m], intrinsics and mount, for kernels."""
        return self._points, *self._lens

    def truth(self, pose: NDArray[np.float64]) -> list[float]:
        """Return corners (8), centroid (2), origin (2) [px] and the camera's place (3) [m].

        The numbers of the methods above in one call, for every tick.
        """
        self._pose[:] = pose[:6]
        camera_pose(self._pose, self._lens[1], self._rotation, self._place)
        project(self._points, self._rotation, self._place, self._lens[0], self._images)
        images: list[float] = self._images.ravel().tolist()
        return images + self._place.tolist()

    def _project(
        self, pose: NDArray[np.float64], points: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        out = np.empty((len(points), 2))
        self._pose[:] = pose[:6]
        camera_pose(self._pose, self._lens[1], self._rotation, self._place)
        project(points, self._rotation, self._place, self._lens[0], out)
        return out

    def _scene_of(self) -> Scene:
        """Return what all channels share."""
        target = self.target
        layout = skin(target.size_m, GREEN, lettered=target.lettered).layout
        return Scene(
            intrinsics=self._lens[0],
            mount=self._lens[1],
            seabed_m=float(target.seabed_m),
            faces=self._faces,
            layout=layout,
            fog=self.water.law == "uwsim",
        )

    def _disturbance_of(self) -> tuple[object, ...] | None:
        """Return the effects for the kernels; None when all are off."""
        effects = self.effects
        if not effects.any:
            return None
        seed = self._noise_seed & 0x7FFFFFFF
        sine, cosine = sin(effects.lamp_cone_rad), cos(effects.lamp_cone_rad)
        return tuple(
            Disturbance(
                exposure_s=float(effects.exposure_s),
                level=float(effects.light_level),
                waves=waves_of(seed)[: WAVES if effects.caustics > 0 else 0],
                wave=amplitude_for(effects.caustics),
                lamp=float(effects.lamp),
                cone=(cosine / sine) ** 2,
                lit=effects.lit,
                snow=float(effects.snow_per_m3),
                scatter=float(effects.scatter_rad),
                fish=effects.fish_per_min / 60.0,
                fish_m=float(effects.fish_length_m),
                frame_s=float(effects.frame_s),
                seed=seed,
            )
        )

    def _channel(self, number: int) -> Channel:
        """Return what one channel has of its own."""
        water, target = self.water, self.target
        return Channel(
            tile=seabed(SEABED_SEED, number),
            skin=skin(target.size_m, number, lettered=target.lettered).quads,
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
        channel = self._channels.get(number)
        if channel is None:
            channel = self._channels[number] = tuple(self._channel(number))
        # A copy: a read-only or strided pose would have the ray-caster compiled once more.
        if self._disturbance is not None:
            self._motion[6:] = 0.0
            self._motion[: len(pose)] = pose
            scene, grain, disturbance = self._scene, self._grain, self._disturbance
            shot = (frame, window)
            special.draw(self._motion, scene, channel, grain, disturbance, shot, self._work, out)
            return
        self._pose[:] = pose[:6]
        raycast.draw(self._pose, self._scene, channel, self._grain, frame, window, self._work, out)
