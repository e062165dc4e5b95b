"""Marine snow: flakes that drift with the water.

Flakes belong to the cubes of a grid that drifts as a whole; those of a cube follow from a hash of
its index. They are painted in the order of the cubes, whatever the window.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.camera.effects import EffectParameters
from seamark.sim.camera.light import lamp_light
from seamark.sim.camera.scene import Channel, Scene
from seamark.sim.camera.seabed import hash01
from seamark.sim.numerics.libm import exp

Array = NDArray[np.float64]
Plane = NDArray[np.float32]  # (rows, columns)

CUBE_M = 0.25
DRIFT_M_S = (0.03, 0.02, 0.004)  # E: slow water, and flakes that sink some 300 m a day
NEAREST_M, FARTHEST_M = 0.15, 3.0  # from the camera; flakes farther away are smaller than a pixel
SMALLEST_M, LARGEST_M = 0.001, 0.005  # E: diameters; small ones are more frequent
ALBEDO = 0.8  # E


@njit(cache=True, nogil=True, error_model="numpy")
def flake_count(i: int, j: int, k: int, density: float, seed: int) -> int:
    """Return the number of flakes in a cube: on average `density` per cubic metre."""
    expected = density * (CUBE_M * CUBE_M * CUBE_M)
    return int(expected + hash01(i, j, seed + 7919 * k))


@njit(cache=True, nogil=True, error_model="numpy")
def attenuated(radiance: float, x: float, y: float, z: float, channel: Channel, fog: bool) -> float:
    """Return the radiance [grey] that arrives from a point in the camera frame, less the veil."""
    if fog:
        optical_depth = channel.attenuation * z
        optical_depth = optical_depth * optical_depth
    else:
        optical_depth = channel.attenuation * np.sqrt(x * x + y * y + z * z)
    return (radiance - channel.veil) * exp(-min(optical_depth, 40.0))


@njit(cache=True, nogil=True, error_model="numpy")
def paint_disc(
    plane: Plane, corner: tuple[int, int], disc: tuple[float, float, float], value: float
) -> None:
    """Blend a disc (column, row, radius) [px] of one grey value into a plane, with a soft edge."""
    u, v, radius = disc
    # A flake smaller than a pixel covers a part of one.
    strength = min(1.0, 4.0 * radius * radius)
    radius = max(radius, 0.5)
    first_row, last_row = int(np.floor(v - radius)), int(np.floor(v + radius)) + 2
    first, last = int(np.floor(u - radius)), int(np.floor(u + radius)) + 2
    for row in range(max(first_row, corner[0]), min(last_row, corner[0] + plane.shape[0])):
        for column in range(max(first, corner[1]), min(last, corner[1] + plane.shape[1])):
            dx, dy = column - u, row - v
            share = radius + 0.5 - np.sqrt(dx * dx + dy * dy)
            if share > 0.0:
                old = plane[row - corner[0], column - corner[1]]
                mixed = old + strength * min(share, 1.0) * (value - old)
                plane[row - corner[0], column - corner[1]] = np.float32(mixed)


@njit(cache=True, nogil=True, error_model="numpy")
def add_snow(
    plane: Plane,
    corner: tuple[int, int],
    size: tuple[int, int],
    extrinsics: tuple[Array, Array],
    scene: Scene,
    channel: Channel,
    effects: EffectParameters,
    time_s: float,
) -> None:
    """Paint the flakes into a plane whose first pixel is at `corner` (row, column).

    `size` is (W, H) of the image; `extrinsics` the camera's axes (3, 3) and position (3,).
    """
    rotation, centre = extrinsics
    low, high = _reach(size, rotation, centre, scene)
    position, drift = np.empty(3), np.empty(3)
    for axis in range(3):
        drift[axis] = DRIFT_M_S[axis] * time_s
        low[axis] = np.floor((low[axis] - drift[axis]) / CUBE_M)
        high[axis] = np.floor((high[axis] - drift[axis]) / CUBE_M)
    for k in range(int(low[2]), int(high[2]) + 1):
        for j in range(int(low[1]), int(high[1]) + 1):
            for i in range(int(low[0]), int(high[0]) + 1):
                for m in range(flake_count(i, j, k, effects.snow, effects.seed)):
                    key = effects.seed + 7919 * k + 16 * m
                    position[0] = (i + hash01(i, j, key + 1)) * CUBE_M + drift[0]
                    position[1] = (j + hash01(i, j, key + 2)) * CUBE_M + drift[1]
                    position[2] = (k + hash01(i, j, key + 3)) * CUBE_M + drift[2]
                    if position[2] < scene.seabed_m:
                        fraction = hash01(i, j, key + 4)
                        diameter = SMALLEST_M + (LARGEST_M - SMALLEST_M) * fraction * fraction
                        flake = position, diameter
                        _paint_flake(plane, corner, extrinsics, flake, scene, channel, effects)


@njit(cache=True, nogil=True, error_model="numpy")
def _paint_flake(
    plane: Plane,
    corner: tuple[int, int],
    extrinsics: tuple[Array, Array],
    flake: tuple[Array, float],
    scene: Scene,
    channel: Channel,
    effects: EffectParameters,
) -> None:
    rotation, centre = extrinsics
    position, diameter = flake
    x, y, z = 0.0, 0.0, 0.0
    for axis in range(3):
        d = position[axis] - centre[axis]
        x += rotation[0, axis] * d
        y += rotation[1, axis] * d
        z += rotation[2, axis] * d
    if z < NEAREST_M or z > FARTHEST_M:
        return
    f = scene.intrinsics[0]
    u, v = f * x / z + scene.intrinsics[1], f * y / z + scene.intrinsics[2]
    radius = 0.5 * diameter * f / z
    reach = radius + 2.0
    if u < corner[1] - reach or u > corner[1] + plane.shape[1] + reach:
        return
    if v < corner[0] - reach or v > corner[0] + plane.shape[0] + reach:
        return
    irradiance = effects.level + lamp_light(x, y, z, channel.attenuation, effects)
    value = attenuated(255.0 * ALBEDO * irradiance, x, y, z, channel, scene.fog) + channel.veil
    paint_disc(plane, corner, (u, v, radius), value)


@njit(cache=True, nogil=True, error_model="numpy")
def _reach(
    size: tuple[int, int], rotation: Array, centre: Array, scene: Scene
) -> tuple[Array, Array]:
    """Return two corners of a box in the world frame around all that the camera can see."""
    low, high = centre.copy(), centre.copy()
    f = scene.intrinsics[0]
    for corner in range(4):
        x = ((size[0] if corner & 1 else 0.0) - scene.intrinsics[1]) / f * FARTHEST_M
        y = ((size[1] if corner & 2 else 0.0) - scene.intrinsics[2]) / f * FARTHEST_M
        for axis in range(3):
            far = centre[axis] + rotation[0, axis] * x + rotation[1, axis] * y
            far += rotation[2, axis] * FARTHEST_M
            low[axis] = min(low[axis], far)
            high[axis] = max(high[axis], far)
    low[2] = max(low[2], centre[2] - FARTHEST_M)
    high[2] = min(high[2], scene.seabed_m)
    return low, high
