"""Light on bodies and in front of them: daylight from above, and a lamp at any place.

Daylight falls on a surface from a half-sphere that is brighter on one side, and the bottom throws a
part of it back: what it gives is linear in the cosine to a direction. The lamp is that of `light`,
but it may be anywhere and point anywhere.
"""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.camera.caustics import caustic_gain
from seamark.sim.camera.effects import EffectParameters
from seamark.sim.camera.light import BACKSCATTER, GLOW_STEPS
from seamark.sim.camera.rows import CHUNK, NODE
from seamark.sim.camera.scene import MARGIN, Channel, Scene
from seamark.sim.numerics.libm import exp
from seamark.sim.numerics.simd import f32x16, maximum, minimum, select_greater, sqrt

if TYPE_CHECKING:
    from seamark.sim.numerics.simd import F32x16

Array = NDArray[np.float64]

# E: daylight comes from 25 degrees off the vertical, from the north-west; (3,) NED towards it.
SUN = (0.29884, -0.29884, -0.90631)
# E: on a surface that faces away, a fifth of what is on one that faces the light. Up counts as 1.
_TOP = 0.6 + 0.4 * 0.90631
EVEN, SKY = 0.6 / _TOP, 0.4 / _TOP
NEAREST_M = 0.02  # [m] before the lamp; nearer than that it gives no light, as in `light`
FARTHEST_M = 6.0  # [m] of what is scattered back
REACH_M = 100.0  # [m] of the light on the seabed, along the optical axis


Point = tuple[float, float, float]


class Lighting(NamedTuple):
    """Light and water for one channel at one instant.

    Numbers only: to hand arrays to what is inlined into loops over pixels counts their references.
    """

    level: float  # of daylight
    lamp: float  # illuminance 1 m before it, in units of daylight; 0 without one
    cone: float  # 1 / tan^2 of its angle
    place: Point  # of the lamp [m] NED
    beam: Point  # where it points
    place_seen: Point  # and
    beam_seen: Point  # in the axes of the camera
    attenuation: float  # [1/m]
    veil: float  # [grey]
    fog: bool


@njit(cache=True, nogil=True, error_model="numpy")
def lighting_of(
    channel: Channel,
    fog: bool,
    effects: EffectParameters,
    lamp: tuple[Array, Array],
    sight: tuple[Array, Array],
) -> Lighting:
    """Return light and water; `lamp` is its place and its beam, `sight` axes and place."""
    place, beam = lamp
    axes, centre = sight
    place_seen, beam_seen = np.zeros(3), np.zeros(3)
    for i in range(3):
        for j in range(3):
            place_seen[i] += axes[i, j] * (place[j] - centre[j])
            beam_seen[i] += axes[i, j] * beam[j]
    return Lighting(
        effects.level,
        effects.lamp,
        effects.cone,
        (place[0], place[1], place[2]),
        (beam[0], beam[1], beam[2]),
        (place_seen[0], place_seen[1], place_seen[2]),
        (beam_seen[0], beam_seen[1], beam_seen[2]),
        channel.attenuation,
        channel.veil * effects.level,
        fog,
    )


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def transmission(path: "F32x16") -> "F32x16":
    """Return exp(-path) as p(-path / 16)^16, p a cubic polynomial: to 5e-5 for path >= 0."""
    t = minimum(path, f32x16(16.0)) * f32x16(-1.0 / 16.0)
    p = f32x16(0.5) + t * f32x16(1.0 / 6.0)
    p = f32x16(1.0) + t * p
    p = f32x16(1.0) + t * p
    p = p * p
    p = p * p
    p = p * p
    return p * p


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def arriving(
    tone: "F32x16", depth: "F32x16", x: "F32x16", y: "F32x16", lighting: Lighting
) -> "F32x16":
    """Return what reaches the camera of radiances [grey] at depths along rays (x, y, 1)."""
    veil, path = f32x16(lighting.veil), f32x16(lighting.attenuation) * depth
    path = path * path if lighting.fog else path * sqrt(f32x16(1.0) + x * x + y * y)
    return (tone - veil) * transmission(path) + veil


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def glow(depth: "F32x16", x: "F32x16", y: "F32x16", lighting: Lighting) -> "F32x16":
    """Return the lamp's light that the water scatters back up to depths, by the midpoint rule."""
    stretch = sqrt(f32x16(1.0) + x * x + y * y)
    step = minimum(depth, f32x16(FARTHEST_M)) * f32x16(1.0 / GLOW_STEPS)
    c = f32x16(lighting.attenuation)
    lx, ly, lz = lighting.place_seen[0], lighting.place_seen[1], lighting.place_seen[2]
    bx, by, bz = lighting.beam_seen[0], lighting.beam_seen[1], lighting.beam_seen[2]
    total = f32x16(0.0)
    for k in range(GLOW_STEPS):
        z = step * f32x16(k + 0.5)
        vx, vy, vz = x * z - f32x16(lx), y * z - f32x16(ly), z - f32x16(lz)
        ahead = vx * f32x16(bx) + vy * f32x16(by) + vz * f32x16(bz)
        square = vx * vx + vy * vy + vz * vz
        total = total + _beam(square, ahead, c * z * stretch, lighting)
    return f32x16(BACKSCATTER) * c * total * step * stretch


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _beam(square: "F32x16", ahead: "F32x16", way: "F32x16", lighting: Lighting) -> "F32x16":
    """Return the lamp's light at places, given the square of their distance from it [m²].

    `ahead` is how far along the beam they are [m], `way` an optical depth that the light still has
    before it.
    """
    one, zero = f32x16(1.0), f32x16(0.0)
    along = ahead * ahead
    cone = f32x16(lighting.cone)
    across = maximum(square - along, zero)
    strength = f32x16(lighting.lamp) * along / ((along + across * cone) * square)
    path = f32x16(lighting.attenuation) * sqrt(square) + way
    light = strength * transmission(path)
    return select_greater(ahead, f32x16(NEAREST_M), light * one, zero)


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def lamp_on(
    to_lamp: "tuple[F32x16, F32x16, F32x16]",
    normal: "tuple[F32x16, F32x16, F32x16]",
    beam: "tuple[F32x16, F32x16, F32x16]",
    lighting: Lighting,
) -> "F32x16":
    """Return the lamp's light on surfaces; the vectors are in any axes."""
    vx, vy, vz = to_lamp
    zero = f32x16(0.0)
    square = vx * vx + vy * vy + vz * vz
    ahead = zero - (vx * beam[0] + vy * beam[1] + vz * beam[2])
    slant = maximum(vx * normal[0] + vy * normal[1] + vz * normal[2], zero) / sqrt(square)
    return slant * _beam(square, ahead, zero, lighting)


@njit(cache=True, nogil=True, error_model="numpy")
def lamp_at(x: float, y: float, z: float, lighting: Lighting) -> float:
    """Return the lamp's light at a point of the world [m] on a surface that faces it."""
    dx, dy, dz = x - lighting.place[0], y - lighting.place[1], z - lighting.place[2]
    ahead = dx * lighting.beam[0] + dy * lighting.beam[1] + dz * lighting.beam[2]
    if ahead < NEAREST_M:
        return 0.0
    square = dx * dx + dy * dy + dz * dz
    along = ahead * ahead
    cone = along / (along + max(square - along, 0.0) * lighting.cone)
    path = lighting.attenuation * np.sqrt(square)
    return float(lighting.lamp * cone / square * exp(-min(path, 40.0)))


@njit(cache=True, nogil=True, error_model="numpy")
def seabed_nodes(
    ground: Array,
    sight: tuple[Array, Array],
    scene: Scene,
    lighting: Lighting,
    effects: EffectParameters,
    window: tuple[int, int, int, int],
    time_s: float,
) -> NDArray[np.float32]:
    """Return the light on the seabed at the nodes that a window needs, (rows, columns).

    `ground` is the map from pixels to the seabed and their inverse depth, `sight` axes and place of
    the camera; node (0, 0) is at (-MARGIN, -MARGIN) px.
    """
    axes, centre = sight
    x0, y0, x1, y1 = window
    f, u0, v0 = scene.intrinsics[0], scene.intrinsics[1], scene.intrinsics[2]
    last_row, last_column = (y1 + MARGIN - 1) // NODE + 2, (x1 + MARGIN + CHUNK) // NODE + 2
    out = np.empty((last_row, last_column), np.float32)
    for j in range((y0 + MARGIN) // NODE, last_row):
        v = float(j * NODE - MARGIN)
        for i in range((x0 + MARGIN) // NODE, last_column):
            u = float(i * NODE - MARGIN)
            inverse = ground[2, 0] * u + ground[2, 1] * v + ground[2, 2]
            z = 1.0 / max(inverse, 1.0 / REACH_M)
            x, y = (u - u0) / f * z, (v - v0) / f * z
            north = centre[0] + axes[0, 0] * x + axes[1, 0] * y + axes[2, 0] * z
            east = centre[1] + axes[0, 1] * x + axes[1, 1] * y + axes[2, 1] * z
            day = lighting.level
            if effects.waves.shape[0] > 0:
                wave, mean = effects.wave
                day *= caustic_gain(north, east, time_s, effects.waves, wave, mean)
            lamp = 0.0
            if lighting.lamp > 0.0:
                lamp = _lamp_on_seabed(north, east, scene.seabed_m, lighting)
            out[j, i] = day + lamp
    return out


@njit(cache=True, nogil=True, error_model="numpy")
def _lamp_on_seabed(north: float, east: float, down: float, lighting: Lighting) -> float:
    x, y, z = north - lighting.place[0], east - lighting.place[1], down - lighting.place[2]
    slant = max(z, 0.0) / np.sqrt(x * x + y * y + z * z)
    return float(slant * lamp_at(north, east, down, lighting))
