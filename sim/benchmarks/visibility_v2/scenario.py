"""What is drawn for one trial of visibility-v2: scene, light, and two paths.

All draws use streams of the trial alone, so that all of its levels share them, and none depends on
a setting: a practice run with other levels has the same scene. E: the ranges are estimates.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seamark.sim.benchmarks.visibility_v2.settings import (
    MIXED,
    VisibilityConfiguration,
)
from seamark.sim.camera.camera import Camera
from seamark.sim.camera.effects import Effects
from seamark.sim.camera.optics import Optics
from seamark.sim.camera.pictures import cutout
from seamark.sim.camera.seabed import TEXEL_M, TILE
from seamark.sim.camera.target import Target, start_pose
from seamark.sim.camera.water import Water
from seamark.sim.engine.prescribed_path import PrescribedPath
from seamark.sim.numerics.libm import PI, exp
from seamark.sim.numerics.random_streams import streams
from seamark.sim.numerics.statistics import mean, root_mean_square
from seamark.sim.settings.targets import LETTERS, SEABED_TEXTURES, TARGET_TEXTURES

OPTICS = Optics(width=320, height=240, focal_px=257.3)  # S: uwsimbenchmarks 988deda
SHARE_OF_AMPLITUDE = 0.2  # of the path's amplitudes: their spread
SHARE_OF_MOTION = 0.3  # of the speed on the turbidity axis: its spread
HEAVE_SHARE, TILT_SHARE = 0.2, 0.6  # relative to horizontal amplitude and heading
VEILS = (0.2, 0.4)  # scattered daylight, share of full scale
SEEDS = 2**63
LN_2 = 0.6931471805599453  # a stop is a factor of two
SQRT_2 = 1.4142135623730951
SAMPLED_S, SAMPLES = 6.0, 240  # of a path with a nominal period of 1 s, to measure its speed

Pose = NDArray[np.float64]  # (6,) [m, rad]
Amplitudes = tuple[float, ...]  # (6,) [m, rad]


@dataclass(frozen=True, slots=True)
class Shape:
    """A path without its speed."""

    centre: tuple[float, ...]  # (6,) [m, rad]
    amplitudes: Amplitudes
    seed: int
    speed_px: float  # [px/s] of the corners in the image, for a nominal period of 1 s

    def at(self, motion_px: float, image_period_s: float) -> PrescribedPath:
        """Return the path whose corners move so far [px] from image to image, on average."""
        return _path(
            self.centre,
            self.amplitudes,
            self.seed,
            period_s=self.speed_px * image_period_s / motion_px,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Scenario:
    """The conditions of a trial."""

    target: Target
    texture: str  # of the target
    ground: str
    water: Water  # perfectly clear, with the trial's noise
    noise_seed: int
    station: tuple[float, ...]  # (6,) [m, rad] the centre of both paths
    turbid: Shape  # of the levels of the turbidity axis
    turbid_motion_px: float  # and how fast it is played
    fast: Shape  # of the levels of the motion axis
    jumps_seed: int

    def as_dict(self) -> dict[str, Any]:
        """Return what differs between trials, as JSON values."""
        return {
            "target_texture": self.texture,
            "ground_texture": self.ground,
            "heading_rad": self.target.heading_rad,
            "camera_noise_grey": self.water.read_sigma_grey,
            "veil": self.water.veil[0],
            "motion_px": self.turbid_motion_px,
            "path_swing_m": self.turbid.amplitudes[0],
            "path_turn_rad": self.turbid.amplitudes[5],
        }

    def water_at(self, optical_depth: float, altitude_m: float) -> Water:
        """Return water of an optical depth from the station to the target."""
        return Water(
            attenuation=(optical_depth / altitude_m,) * 3,
            veil=self.water.veil,
            read_sigma_grey=self.water.read_sigma_grey,
            shot_gain=self.water.shot_gain,
        )

    def camera(self, optical_depth: float, altitude_m: float, *, exposure_s: float = 0.0) -> Camera:
        """Return the camera in water of an optical depth from the station to the target."""
        return Camera(
            OPTICS,
            self.water_at(optical_depth, altitude_m),
            self.target,
            noise_seed=self.noise_seed,
            effects=Effects(exposure_s=exposure_s),
            ground=self.ground,
        )


@lru_cache(maxsize=4)
def draw_scenario(config: VisibilityConfiguration, seed: int, trial: int) -> Scenario:
    """Return the conditions of a trial, which depend on these values only."""
    random = streams(seed, trial, 0)
    share = random.scene.random(16).tolist()
    seeds = random.scene.integers(SEEDS, size=3).tolist()
    texture = _texture(config, trial)
    tile_m = TILE * TEXEL_M
    target = Target(
        north_m=tile_m * share[2],
        east_m=tile_m * share[3],
        heading_rad=2.0 * PI * share[4],
        picture=None if texture == LETTERS else cutout(texture, share[0], share[1]),
    )
    station = tuple(start_pose(OPTICS, target, config.altitude_m).tolist())
    gain = exp(config.light_stops * share[5] * LN_2)
    veil = VEILS[0] + (VEILS[1] - VEILS[0]) * share[6]
    water = Water(
        attenuation=(0.0,) * 3,
        veil=(veil,) * 3,
        read_sigma_grey=gain * config.camera_noise_grey,
        shot_gain=gain * Water().shot_gain,
    )
    noise_seed = int(random.camera.integers(SEEDS))
    camera = Camera(OPTICS, water, target, noise_seed=noise_seed)
    turbid = _shape(camera, station, _amplitudes(config, share[7:9]), seeds[0])
    fast = _shape(camera, station, _amplitudes(config, share[9:11]), seeds[1])
    return Scenario(
        target=target,
        texture=texture,
        ground=_ground(config, texture, share[11]),
        water=water,
        noise_seed=noise_seed,
        station=station,
        turbid=turbid,
        turbid_motion_px=config.path_motion_px * around_one(SHARE_OF_MOTION, share[12]),
        fast=fast,
        jumps_seed=seeds[2],
    )


def _texture(config: VisibilityConfiguration, trial: int) -> str:
    """Return what covers the target; if mixed, each in turn, so that all count alike."""
    if config.target_texture != MIXED:
        return config.target_texture
    return list(TARGET_TEXTURES)[trial % len(TARGET_TEXTURES)]


def _ground(config: VisibilityConfiguration, texture: str, share: float) -> str:
    if config.ground_texture != MIXED:
        return config.ground_texture
    others = [ground for ground in SEABED_TEXTURES if ground != texture]
    return others[int(share * len(others))]


def around_one(spread: float, share: float) -> float:
    """Return a factor between 1 - spread and 1 + spread for a share from 0 to 1."""
    return 1.0 + spread * (2.0 * share - 1.0)


def _amplitudes(config: VisibilityConfiguration, shares: Sequence[float]) -> Amplitudes:
    swing = config.path_swing_m * around_one(SHARE_OF_AMPLITUDE, shares[0])
    turn = config.path_turn_rad * around_one(SHARE_OF_AMPLITUDE, shares[1])
    return (swing, swing, HEAVE_SHARE * swing, TILT_SHARE * turn, TILT_SHARE * turn, turn)


def _path(
    centre: Sequence[float], amplitudes: Amplitudes, seed: int, *, period_s: float
) -> PrescribedPath:
    random = np.random.Generator(np.random.PCG64(seed))
    return PrescribedPath(centre, amplitudes, period_s=period_s, random=random)


def _shape(camera: Camera, centre: tuple[float, ...], amplitudes: Amplitudes, seed: int) -> Shape:
    """Return a path's shape with its speed: mean root mean square displacement of the corners."""
    path = _path(centre, amplitudes, seed, period_s=1.0)
    step_s = SAMPLED_S / SAMPLES
    corners = [
        camera.corners(np.array(path.pose_and_velocity(k * step_s)[0])).ravel().tolist()
        for k in range(SAMPLES + 1)
    ]
    moved = [displacement(a, b) for a, b in pairwise(corners)]
    return Shape(centre, amplitudes, seed, mean(moved) / step_s)


def displacement(first: Sequence[float], second: Sequence[float]) -> float:
    """Return the root mean square distance [px] of four corners (8,) from four others."""
    return SQRT_2 * root_mean_square([a - b for a, b in zip(first, second, strict=True)])
