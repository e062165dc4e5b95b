"""What one colour channel of a camera is drawn with, for compiled code that draws it."""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.camera import raycast, raycast_effects
from seamark.sim.camera.effects import EffectParameters
from seamark.sim.camera.scene import Buffers, Channel, Scene, SensorNoise
from seamark.sim.numerics.arrays import Array


class Pencil(NamedTuple):
    """What the kernels draw one colour channel of a camera with."""

    scene: Scene
    channel: Channel
    grain: SensorNoise
    effects: EffectParameters  # of `raycast_effects`, where there are any
    altered: bool  # whether there are any


@njit(cache=True, nogil=True, error_model="numpy")
def draw(
    pencil: Pencil,
    motion: Array,
    frame: int,
    window: raycast.Window,
    buffers: Buffers,
    out: NDArray[np.uint8],
) -> None:
    """Draw a window of an image; `motion` is pose and velocities, (12,), as `Camera` has them."""
    scene, channel, grain, effects, altered = pencil
    if altered:
        at = (frame, window)
        raycast_effects.draw(motion, scene, channel, grain, effects, at, buffers, out)
    else:
        raycast.draw(motion[:6], scene, channel, grain, frame, window, buffers, out)
