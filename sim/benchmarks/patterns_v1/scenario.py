"""What is drawn for one level of patterns-v1: bottom, light, particles, and the camera's passage.

Every level has a bottom of its own, so nothing that a program saw before helps it. No draw depends
on a setting: a level has the same scene in a practice run with other settings. E: the ranges are
estimates.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import lru_cache

import numpy as np

from seamark.sim.benchmarks.patterns_v1.settings import PatternsConfiguration
from seamark.sim.camera.bottom.bottom import STRIP_M, Bottom, draw_bottom
from seamark.sim.camera.bottom.camera import BottomCamera
from seamark.sim.camera.effects import Effects
from seamark.sim.camera.geometry import camera_pose
from seamark.sim.camera.optics import VISIBILITY
from seamark.sim.camera.target import Target
from seamark.sim.camera.water import Water
from seamark.sim.engine.prescribed_path import PrescribedPath
from seamark.sim.numerics.libm import PI, exp
from seamark.sim.numerics.random_streams import streams

OPTICS = VISIBILITY
SEABED_M = Target().seabed_m
VEILS = (0.2, 0.4)  # scattered daylight, share of full scale; as in visibility-v2
SWAY_M, HEAVE_M, SWING_RAD = 0.06, 0.04, 0.03  # of the passage: amplitudes
SWING_PERIOD_S = 6.0
MOST_CAUSTICS = 0.25  # coefficient of variation of the daylight on the bottom
SEEDS = 2**63
LN_2 = 0.6931471805599453  # a stop is a factor of two


@dataclass(frozen=True, slots=True, kw_only=True)
class Conditions:
    """Water, light and particles of a level."""

    altitude_m: float  # of the camera
    read_sigma_grey: float
    shot_gain: float
    veil: float
    caustics: float
    snow_per_m3: float
    fish_per_min: float

    def as_dict(self) -> dict[str, float]:
        """Return them as JSON values."""
        return asdict(self)

    def water(self, optical_depth: float) -> Water:
        """Return water of an optical depth from the camera down to the bottom."""
        return Water(
            attenuation=(optical_depth / self.altitude_m,) * 3,
            veil=(self.veil,) * 3,
            read_sigma_grey=self.read_sigma_grey,
            shot_gain=self.shot_gain,
        )


@dataclass(frozen=True, slots=True)
class Scenario:
    """A level before it runs."""

    conditions: Conditions
    bottom: Bottom
    camera: BottomCamera
    path: PrescribedPath


def draw_conditions(config: PatternsConfiguration, seed: int, trial: int, level: int) -> Conditions:
    """Return the conditions of a level, which depend on these values only."""
    share = streams(seed, trial, level).scene.random(6).tolist()
    gain = exp(config.light_stops * share[0] * LN_2)  # of a camera that makes up for the light
    return Conditions(
        altitude_m=config.altitude_m + config.altitude_spread_m * (2.0 * share[1] - 1.0),
        read_sigma_grey=gain * config.camera_noise_grey,
        shot_gain=gain * Water().shot_gain,
        veil=VEILS[0] + (VEILS[1] - VEILS[0]) * share[2],
        caustics=MOST_CAUSTICS * share[3],
        snow_per_m3=config.snow_per_m3 * share[4],
        fish_per_min=config.fish_per_min * share[5],
    )


@lru_cache(maxsize=2)
def draw_scenario(config: PatternsConfiguration, seed: int, trial: int, level: int) -> Scenario:
    """Return a level, painted, which depends on these values only."""
    random = streams(seed, trial, level)
    conditions = draw_conditions(config, seed, trial, level)
    bottom = draw_bottom(random.things, burial=config.burial)
    camera = BottomCamera(
        OPTICS,
        conditions.water(config.optical_depths[level]),
        bottom,
        noise_seed=int(random.camera.integers(SEEDS)),
        effects=Effects(
            caustics=conditions.caustics,
            snow_per_m3=conditions.snow_per_m3,
            fish_per_min=conditions.fish_per_min,
            frame_s=config.control_period_s,
        ),
    )
    path = _passage(config, bottom, conditions.altitude_m, random.start)
    return Scenario(conditions, bottom, camera, path)


def _passage(
    config: PatternsConfiguration,
    bottom: Bottom,
    altitude_m: float,
    random: np.random.Generator,
) -> PrescribedPath:
    """Return a path on which the middle of the image follows the strip, at any heading."""
    share = random.random(5).tolist()
    tilt = [config.tilt_rad * (2.0 * one - 1.0) for one in share[:2]]
    attitude = [*tilt, 2.0 * PI * share[2]]
    speed = config.speed_m_s if share[3] < 0.5 else -config.speed_m_s
    north, east, down = _below(attitude, altitude_m)
    return PrescribedPath(
        [STRIP_M * share[4] - north, bottom.east_m - east, SEABED_M - down, *attitude],
        [SWAY_M, SWAY_M, HEAVE_M, SWING_RAD, SWING_RAD, SWING_RAD],
        period_s=SWING_PERIOD_S,
        random=random,
        drift=(speed, 0.0, 0.0, 0.0, 0.0, 0.0),
    )


def _below(attitude: Sequence[float], altitude_m: float) -> tuple[float, float, float]:
    """Return where the optical axis meets the bottom, relative to the vehicle's origin [m]."""
    axes, position = np.empty((3, 3)), np.empty(3)
    camera_pose(np.array([0.0, 0.0, 0.0, *attitude]), np.array(OPTICS.mount_m), axes, position)
    range_m = altitude_m / float(axes[2, 2])
    north, east = (float(position[i] + range_m * axes[2, i]) for i in range(2))
    return north, east, float(position[2]) + altitude_m
