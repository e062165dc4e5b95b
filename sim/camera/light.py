"""Light other than normal daylight: illuminance of surfaces, and backscatter of a lamp.

In units of daylight and albedo, like all radiances here. Daylight has a level and caustics; a lamp
beside the camera gives E = lamp / d^2 at the distance d, reduced by its cone
(1 / (1 + tan^2 / tan^2 of the half angle)), by the inclination of the surface and by the water.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.camera.caustics import caustic_gain
from seamark.sim.camera.effects import LAMP_FORWARD_M, EffectParameters
from seamark.sim.camera.rows import CHUNK, NODE
from seamark.sim.camera.scene import MARGIN, Scene
from seamark.sim.numerics.libm import exp

GLOW_STEPS = 8  # of the integral along a ray
# E: share of the attenuated light scattered straight back: particle albedo 0.6, times pi, times a
# phase function of 0.016 per steradian backwards.
BACKSCATTER = 0.03


@njit(cache=True, nogil=True, error_model="numpy")
def lamp_light(
    x: float, y: float, z: float, attenuation: float, effects: EffectParameters
) -> float:
    """Return the lamp's light at a point [m], camera frame, on a surface that faces the lamp."""
    if z < 0.02:
        return 0.0
    ahead = y + LAMP_FORWARD_M  # image down is aft
    across = x * x + ahead * ahead
    square = across + z * z
    cone = 1.0 / (1.0 + across / (z * z) * effects.cone)
    return effects.lamp * cone / square * exp(-min(attenuation * np.sqrt(square), 40.0))


@njit(cache=True, nogil=True, error_model="numpy")
def light_nodes(
    g: NDArray[np.float64],
    scene: Scene,
    water: tuple[float, float],
    effects: EffectParameters,
    window: tuple[int, int, int, int],
    extrinsics: tuple[NDArray[np.float64], NDArray[np.float64]],
    time_s: float,
) -> NDArray[np.float32]:
    """Return (3, rows, columns): light on the seabed, on the box's top, and backscatter [albedo].

    `water` is the attenuation and the depth of the top as a share of that of the seabed;
    `extrinsics` the axes (3, 3) and the position (3,) of the camera.
    """
    attenuation, nearer = water
    x0, y0, x1, y1 = window
    f = scene.intrinsics[0]
    last_row, last_column = (y1 + MARGIN - 1) // NODE + 2, (x1 + MARGIN + CHUNK) // NODE + 2
    out = np.zeros((3, last_row, last_column), np.float32)
    for j in range((y0 + MARGIN) // NODE, last_row):
        v = float(j * NODE - MARGIN)
        y = (v - scene.intrinsics[2]) / f
        for i in range((x0 + MARGIN) // NODE, last_column):
            u = float(i * NODE - MARGIN)
            x = (u - scene.intrinsics[1]) / f
            depth = 1.0 / max(g[2, 0] * u + g[2, 1] * v + g[2, 2], 1e-3)
            for k in range(2):
                z = depth * (1.0 if k == 0 else nearer)
                ahead = y * z + LAMP_FORWARD_M
                slant = z / np.sqrt(x * z * x * z + ahead * ahead + z * z)
                e = lamp_light(x * z, y * z, z, attenuation, effects)
                day = effects.level * _daylight(x * z, y * z, z, extrinsics, effects, time_s)
                out[k, j, i] = day + slant * e
            out[2, j, i] = _glow(x, y, depth, attenuation, effects)
    return out


@njit(cache=True, nogil=True, error_model="numpy")
def _daylight(
    x: float,
    y: float,
    z: float,
    extrinsics: tuple[NDArray[np.float64], NDArray[np.float64]],
    effects: EffectParameters,
    time_s: float,
) -> float:
    """Return the daylight at a point [m], camera frame, as a multiple of its mean."""
    if effects.waves.shape[0] == 0:
        return 1.0
    axes, position = extrinsics
    north = position[0] + axes[0, 0] * x + axes[1, 0] * y + axes[2, 0] * z
    east = position[1] + axes[0, 1] * x + axes[1, 1] * y + axes[2, 1] * z
    return caustic_gain(north, east, time_s, effects.waves, effects.wave[0], effects.wave[1])


@njit(cache=True, nogil=True, error_model="numpy")
def _glow(x: float, y: float, depth: float, attenuation: float, effects: EffectParameters) -> float:
    """Return the lamp's light that the water scatters back along a ray, by the midpoint rule."""
    if effects.lamp == 0.0:
        return 0.0
    stretch = np.sqrt(1.0 + x * x + y * y)
    step = min(depth, 6.0) / GLOW_STEPS
    total = 0.0
    for k in range(GLOW_STEPS):
        z = (k + 0.5) * step
        back = exp(-min(attenuation * z * stretch, 40.0))
        total += lamp_light(x * z, y * z, z, attenuation, effects) * back
    return float(BACKSCATTER * attenuation * total * step * stretch)
