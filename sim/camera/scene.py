"""What the ray-caster is given: scene, channels, noise and the buffers of a row."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from seamark.sim.camera.rows import CHUNK, NODE

STRIP = 12288  # [px] drawn at once: few calls a picture, and the buffers stay in the second cache
MARGIN = 2 * NODE  # [px] how far beyond the picture a row may be asked for
Array = NDArray[np.float64]
Row = NDArray[np.float32]
Rows = NDArray[np.float32]
Texels = NDArray[np.int32]


class Channel(NamedTuple):
    """What one colour channel has of its own."""

    tile: Texels  # the seabed in blocks
    skin: Texels  # the faces' packed textures
    attenuation: float  # [1/m]
    veil: float  # [grey]
    number: int  # 0 red, 1 green, 2 blue


class Scene(NamedTuple):
    """What all channels share. Lens, place of the camera on the body, ground and box."""

    intrinsics: Array  # (3,) focal length, principal column, principal row [px]
    mount: Array  # (3,) [m] body frame
    seabed_m: float
    faces: Array  # (n, 12)
    layout: Texels  # (n, 3) where each face lies in the skin
    fog: bool  # UWSim's law instead of Beer-Lambert


class Grain(NamedTuple):
    """The camera's noise."""

    bank: Row
    seed: int
    read_variance: float  # [grey^2]
    shot_gain: float  # [grey]


class Work(NamedTuple):
    """Buffers of a strip of rows."""

    light: Row  # [grey] the strip
    ground: Row  # [grey] the strip before the faces
    transmission: Row  # of the strip
    gain: Rows  # (2, strip) light on ground and faces
    levels: NDArray[np.uint8]  # the strip in grey levels


def work_for(width: int) -> Work:
    """Return buffers for pictures of that width [px]."""
    wide = (width + 2 * MARGIN) // CHUNK * CHUNK + 3 * CHUNK
    strip = max(STRIP, wide)
    return Work(
        light=np.zeros(strip, np.float32),
        ground=np.zeros(strip, np.float32),
        transmission=np.zeros(strip, np.float32),
        gain=np.zeros((2, strip), np.float32),
        levels=np.zeros(strip, np.uint8),
    )
