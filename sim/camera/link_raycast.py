"""Renders what a camera on a link sees: seabed, bodies, water, noise."""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.camera import rows
from seamark.sim.camera.body_rows import Layers, draw_bodies, draw_glow, find_bodies
from seamark.sim.camera.effects import EffectParameters
from seamark.sim.camera.instant import Instant, Links, Stage, Tones, Window, instant_at
from seamark.sim.camera.open_seabed import draw_seabed
from seamark.sim.camera.raycast import expose_strip, fetch_noise, padded_columns
from seamark.sim.camera.scene import MARGIN, STRIP, Buffers, SensorNoise

Row = NDArray[np.float32]


class Memory(NamedTuple):
    """Buffers of a strip of rows."""

    strip: Buffers
    layers: Layers


@njit(cache=True, nogil=True, error_model="numpy")
def render_rows(
    instant: Instant,
    row: int,
    columns: tuple[int, int],
    tones: Tones,
    memory: Memory,
    light: Row,
    whole: bool,
) -> None:
    """Write what reaches the camera [grey] in a strip of rows, (rows * width,), from `row` on.

    `columns` is the window's first column and the one after its last. The depth of what all pixels
    show is known after it if `whole`.
    """
    start, width = padded_columns(columns[0], columns[1])
    extent, lit = (row, start, width), instant.lighting.lamp > 0.0
    gain = memory.strip.gain[0, :0]
    if instant.nodes.shape[0]:
        gain = memory.strip.gain[0, : light.shape[0]]
        rows.interpolate_nodes(instant.nodes, (row + MARGIN, start + MARGIN, width), gain)
    layers = memory.layers
    bodies = find_bodies(
        instant, tones.paints.texels, extent, light.shape[0] // width, layers, whole or lit
    )
    draw_seabed(
        instant.ground,
        tones.channel.seabed,
        extent,
        instant.lens,
        instant.lighting,
        gain,
        layers.hidden,
        light,
    )
    if bodies:
        draw_bodies(instant, extent, layers, light)
    if lit:
        draw_glow(instant, extent, layers, light)


@njit(cache=True, nogil=True, error_model="numpy")
def draw(
    placed: Links,
    stage: Stage,
    tones: Tones,
    grain: SensorNoise,
    effects: EffectParameters,
    frame_window: tuple[int, Window],
    memory: Memory,
    out: NDArray[np.uint8],
) -> None:
    """Render a window of one channel without effects into `out` (H, W) uint8."""
    frame, window = frame_window
    x0, y0, x1, y1 = window
    instant = instant_at(placed, stage, tones, effects, window, 0.0)
    start, width = padded_columns(x0, x1)
    height = max(1, STRIP // width)
    for row in range(y0, y1, height):
        light = memory.strip.light[: min(height, y1 - row) * width]
        extent, noise_key = (row, start, x0, x1), (frame, tones.channel.number)
        fetch_noise(extent, light.shape[0] // width, grain, noise_key)
        render_rows(instant, row, (x0, x1), tones, memory, light, False)
        expose_strip(light, extent, grain, noise_key, memory.strip.levels, out)
