"""Inputs of the ray-caster: scene, colour channels, noise and buffers."""

from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from seamark.sim.camera.rows import CHUNK, NODE

STRIP = 12288  # [px] rendered at once: few calls per image, and the buffers fit into the L2 cache
MARGIN = 2 * NODE  # [px] rows may be rendered this far beyond the image
Array = NDArray[np.float64]
Row = NDArray[np.float32]
Rows = NDArray[np.float32]
Texels = NDArray[np.uint16]
Places = NDArray[np.int32]


class Channel(NamedTuple):
    """What belongs to one colour channel."""

    seabed: Texels  # packed tile, see seabed.py
    box_texture: Texels  # the faces' packed textures
    attenuation: float  # [1/m]
    veil: float  # [grey]
    number: int  # 0 red, 1 green, 2 blue


class Scene(NamedTuple):
    """What all channels share: optics, mount of the camera, seabed and box."""

    intrinsics: Array  # (3,) focal length, principal column, principal row [px]
    mount: Array  # (3,) [m] body frame
    seabed_m: float
    faces: Array  # (n, 12)
    layout: Places  # (n, 3) position of each face in the texture: offset, columns, rows
    fog: bool  # UWSim's law instead of Beer-Lambert


class SensorNoise(NamedTuple):
    """The camera's noise."""

    bank: Row
    seed: int
    read_variance: float  # [grey^2]
    shot_gain: float  # [grey]


class Buffers(NamedTuple):
    """Buffers of a strip of rows."""

    light: Row  # [grey] the strip
    ground: Row  # [grey] the strip before the faces
    transmission: Row  # of the strip
    gain: Rows  # (2, strip) light on ground and faces
    levels: NDArray[np.uint8]  # the strip in grey levels


@register_jitable
def buffers_for(width: int) -> Buffers:
    """Return buffers for images of this width [px]."""
    wide = (width + 2 * MARGIN) // CHUNK * CHUNK + 3 * CHUNK
    strip = max(STRIP, wide)
    return Buffers(
        light=np.zeros(strip, np.float32),
        ground=np.zeros(strip, np.float32),
        transmission=np.zeros(strip, np.float32),
        gain=np.zeros((2, strip), np.float32),
        levels=np.zeros(strip, np.uint8),
    )
