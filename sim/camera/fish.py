"""Fish that swim between the camera and the target, on a seeded schedule.

Time is divided into slots; in each, one fish crosses directly above the target, at a time and in a
direction given by a hash. Where there is no target, there are no fish.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.camera.effects import EffectParameters
from seamark.sim.camera.geometry import plane_homography
from seamark.sim.camera.scene import Channel, Scene
from seamark.sim.camera.seabed import hash01
from seamark.sim.camera.snow import attenuated
from seamark.sim.numerics.libm import PI, sincos

Array = NDArray[np.float64]

SPEED_M_S = 0.5  # E
ABOVE_M = 0.35  # E: height above the target's top
RUN_UP_M = 1.2  # E: length of its path without its own length
SLENDER = 0.34  # E: width of the body as a share of the length
ALBEDO = 0.16  # E: a dark back


@njit(cache=True, nogil=True, error_model="numpy")
def crossing(time_s: float, effects: EffectParameters) -> tuple[bool, float, float]:
    """Return whether a fish is present, its position along its path [m] and its heading [rad]."""
    slot_s = 1.0 / effects.fish
    slot = int(np.floor(time_s / slot_s))
    way = effects.fish_m + RUN_UP_M
    lasts = min(way / SPEED_M_S, slot_s)
    begins = slot * slot_s + hash01(slot, 1, effects.seed) * (slot_s - lasts)
    passed = (time_s - begins) / lasts
    heading = 2.0 * PI * hash01(slot, 2, effects.seed)
    return 0.0 <= passed < 1.0, (passed - 0.5) * way, heading


@njit(cache=True, nogil=True, error_model="numpy")
def add_fish(
    plane: NDArray[np.float32],
    corner: tuple[int, int],
    extrinsics: tuple[Array, Array],
    scene: Scene,
    channel: Channel,
    effects: EffectParameters,
    time_s: float,
) -> None:
    """Paint the fish into a plane (rows, columns) whose first pixel is at `corner` (row, column).

    Its outline is an ellipse with a tail; the coverage of a pixel follows from its distance to it.
    """
    there, along, heading = crossing(time_s, effects)
    if not there or scene.faces.shape[0] == 0:
        return
    rotation, centre = extrinsics
    s, c = sincos(heading)
    top = scene.faces[0]
    spot = np.zeros(12)
    spot[0] = top[0] + 0.5 * (top[3] + top[6]) + along * c
    spot[1] = top[1] + 0.5 * (top[4] + top[7]) + along * s
    spot[2] = top[2] - ABOVE_M
    # Axes of the plane: nose and left side, in half lengths of the body.
    half = 0.5 * effects.fish_m
    spot[3], spot[4] = half * c, half * s
    spot[6], spot[7] = -half * s, half * c
    g = np.empty((3, 3))
    if spot[2] - centre[2] < 0.05 or not plane_homography(
        spot, rotation, centre, scene.intrinsics, g
    ):
        return
    for row in range(plane.shape[0]):
        for column in range(plane.shape[1]):
            u, v = float(column + corner[1]), float(row + corner[0])
            inverse = g[2, 0] * u + g[2, 1] * v + g[2, 2]
            if inverse < 1e-3:
                continue
            a = (g[0, 0] * u + g[0, 1] * v + g[0, 2]) / inverse
            b = (g[1, 0] * u + g[1, 1] * v + g[1, 2]) / inverse
            pixels = half * scene.intrinsics[0] * inverse  # of half a length
            cover = min(max(_inside(a, b) * pixels + 0.5, 0.0), 1.0)
            if cover > 0.0:
                x = (u - scene.intrinsics[1]) / scene.intrinsics[0] / inverse
                y = (v - scene.intrinsics[2]) / scene.intrinsics[0] / inverse
                tone = 255.0 * ALBEDO * effects.level * (1.0 + 0.5 * min(abs(b) / SLENDER, 1.0))
                value = attenuated(tone, x, y, 1.0 / inverse, channel, scene.fog) + channel.veil
                old = plane[row, column]
                plane[row, column] = np.float32(old + cover * (value - old))


@njit(cache=True, nogil=True, error_model="numpy")
def _inside(a: float, b: float) -> float:
    """Return how far inside the outline a point is, in half lengths; negative outside."""
    q = np.sqrt((a - 0.2) * (a - 0.2) / 0.64 + b * b / (SLENDER * SLENDER))
    body = (1.0 - q) * SLENDER
    half_width = 0.06 + 0.45 * max(-a - 0.5, 0.0)  # the tail widens backwards
    tail = min(a + 1.0, -0.4 - a, half_width - abs(b))
    return float(max(body, tail))
