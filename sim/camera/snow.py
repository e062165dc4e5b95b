"""Marine snow: flakes that drift with the water.

Flakes belong to the cubes of a grid that drifts as a whole; those of a cube follow from a hash of
its index. They are painted in the order of the cubes, whatever the window.
"""

from typing import NamedTuple

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


class Painting(NamedTuple):
    """A part of an image that flakes are painted into."""

    plane: Plane
    corner: tuple[int, int]  # row and column of its first pixel
    size: tuple[int, int]  # (W, H) of the image
    depth: Plane  # [m] of what the pixels show; empty if no flake is behind anything


class Eye(NamedTuple):
    """Axes (3, 3) by row and place (3,) of a camera."""

    axes: Array
    centre: Array


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
    painting: Painting, disc: tuple[float, float, float], z: float, value: float
) -> None:
    """Blend a disc (column, row, radius) [px] of one grey value into a plane, with a soft edge.

    It is at the depth z [m], and is not painted where something is nearer.
    """
    u, v, radius = disc
    plane, corner, depth = painting.plane, painting.corner, painting.depth
    # A flake smaller than a pixel covers a part of one.
    strength = min(1.0, 4.0 * radius * radius)
    radius = max(radius, 0.5)
    first_row, last_row = int(np.floor(v - radius)), int(np.floor(v + radius)) + 2
    first, last = int(np.floor(u - radius)), int(np.floor(u + radius)) + 2
    for row in range(max(first_row, corner[0]), min(last_row, corner[0] + plane.shape[0])):
        for column in range(max(first, corner[1]), min(last, corner[1] + plane.shape[1])):
            dx, dy = column - u, row - v
            share = radius + 0.5 - np.sqrt(dx * dx + dy * dy)
            if depth.shape[0] and depth[row - corner[0], column - corner[1]] < z:
                continue
            if share > 0.0:
                old = plane[row - corner[0], column - corner[1]]
                mixed = old + strength * min(share, 1.0) * (value - old)
                plane[row - corner[0], column - corner[1]] = np.float32(mixed)


@njit(cache=True, nogil=True, error_model="numpy")
def add_snow(
    painting: Painting,
    eyes: tuple[Eye, Eye],
    scene: Scene,
    channel: Channel,
    effects: EffectParameters,
    time_s: float,
) -> None:
    """Paint the flakes; `eyes` is the camera, and the camera that the lamp is beside."""
    rotation, centre = eyes[0]
    size = painting.size
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
                        _paint_flake(painting, eyes, flake, scene, channel, effects)


@njit(cache=True, nogil=True, error_model="numpy")
def _paint_flake(
    painting: Painting,
    eyes: tuple[Eye, Eye],
    flake: tuple[Array, float],
    scene: Scene,
    channel: Channel,
    effects: EffectParameters,
) -> None:
    plane, corner = painting.plane, painting.corner
    position, diameter = flake
    x, y, z = _in_axes(position, eyes[0])
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
    lx, ly, lz = _in_axes(position, eyes[1])
    irradiance = effects.level + lamp_light(lx, ly, lz, channel.attenuation, effects)
    value = attenuated(255.0 * ALBEDO * irradiance, x, y, z, channel, scene.fog) + channel.veil
    paint_disc(painting, (u, v, radius), z, value)


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _in_axes(point: Array, eye: Eye) -> tuple[float, float, float]:
    rotation, centre = eye
    x, y, z = 0.0, 0.0, 0.0
    for axis in range(3):
        d = point[axis] - centre[axis]
        x += rotation[0, axis] * d
        y += rotation[1, axis] * d
        z += rotation[2, axis] * d
    return x, y, z


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
