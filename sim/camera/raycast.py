"""Renders a window of the image row by row: seabed, faces of the box, water, noise.

The buffers of a row begin at a column that is a multiple of NODE and consist of whole CHUNKs, so
that no loop has a scalar remainder; what is computed outside the window is dropped.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.camera import rows
from seamark.sim.camera.faces import Outlines, draw_faces, outlines
from seamark.sim.camera.geometry import camera_pose, plane_homography
from seamark.sim.camera.rows import CHUNK, NODE
from seamark.sim.camera.scene import MARGIN, STRIP, Buffers, Channel, Scene, SensorNoise
from seamark.sim.camera.seabed import TEXEL_M
from seamark.sim.numerics.libm import exp
from seamark.sim.numerics.simd import WIDTH, prefetch
from seamark.sim.numerics.stack import on_stack
from seamark.sim.numerics.uncounted import uncounted

NOISE_LENGTH = 1 << 18  # [samples] of the bank, a power of two
Array = NDArray[np.float64]
Row = NDArray[np.float32]
Window = tuple[int, int, int, int]
_F = np.float32


class View(NamedTuple):
    """One pose of the camera."""

    ground: Array  # (3, 3) pixel -> texel/z, texel/z, 1/z of the seabed
    north: int
    east: int
    nodes: NDArray[np.float32]  # (rows, columns) transmission to the seabed
    lamp: NDArray[np.float32]  # (3, rows, columns) light on seabed and top, backscatter; or empty
    outlines: Outlines


@njit(cache=True, nogil=True, error_model="numpy")
def noise_start(seed: int, frame: int, row: int, channel: int) -> int:
    """Return where in the noise bank a row starts: SplitMix64's finaliser over four integers."""
    h = np.uint64(seed) * np.uint64(0x9E3779B97F4A7C15)
    h = h ^ (np.uint64(frame) + np.uint64(1)) * np.uint64(0xBF58476D1CE4E5B9)
    h = h ^ (np.uint64(row) * np.uint64(4) + np.uint64(channel)) * np.uint64(0x94D049BB133111EB)
    h = (h ^ (h >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    h = (h ^ (h >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    h = h ^ (h >> np.uint64(31))
    return int(h & np.uint64(NOISE_LENGTH - 1))


@njit(cache=True, nogil=True, error_model="numpy")
def seabed_map(
    depth: float, rotation: Array, centre: Array, intrinsics: Array, g: Array
) -> tuple[int, int]:
    """Write the seabed's homography relative to the texel below the camera; return that texel."""
    north = np.floor(centre[0] / TEXEL_M)
    east = np.floor(centre[1] / TEXEL_M)
    plane = on_stack(np.float64, 12)
    plane[:] = 0.0
    plane[0] = north * TEXEL_M
    plane[1] = east * TEXEL_M
    plane[2] = depth
    plane[3] = TEXEL_M
    plane[7] = TEXEL_M
    plane_homography(plane, rotation, centre, intrinsics, g)
    for k in range(3):
        g[0, k] -= 0.5 * g[2, k]
        g[1, k] -= 0.5 * g[2, k]
    return int(north), int(east)


@njit(cache=True, nogil=True, error_model="numpy")
def _transmission_nodes(
    g: Array, scene: Scene, attenuation: float, window: Window
) -> NDArray[np.float32]:
    """Return the seabed's transmission at the nodes that the window needs.

    (rows, columns) for the whole image; node (0, 0) is at (-MARGIN, -MARGIN) px.
    """
    x0, y0, x1, y1 = window
    f = scene.intrinsics[0]
    last_row, last_column = (y1 + MARGIN - 1) // NODE + 2, (x1 + MARGIN + CHUNK) // NODE + 2
    out = np.empty((last_row, last_column), np.float32)
    for j in range((y0 + MARGIN) // NODE, last_row):
        v = float(j * NODE - MARGIN)
        y = (v - scene.intrinsics[2]) / f
        for i in range((x0 + MARGIN) // NODE, last_column):
            u = float(i * NODE - MARGIN)
            x = (u - scene.intrinsics[1]) / f
            depth = 1.0 / max(g[2, 0] * u + g[2, 1] * v + g[2, 2], 1e-3)
            if scene.fog:
                out[j, i] = exp(-min((attenuation * depth) ** 2, 40.0))
            else:
                out[j, i] = exp(-min(attenuation * depth * np.sqrt(1.0 + x * x + y * y), 40.0))
    return out


@njit(cache=True, nogil=True, error_model="numpy")
def view_from(pose: Array, scene: Scene, attenuation: float, window: Window) -> View:
    """Return the view of the scene from a pose (6,), for the rows of a window."""
    rotation = np.empty((3, 3))
    centre = np.empty(3)
    camera_pose(pose, scene.mount, rotation, centre)
    g = np.empty((3, 3))
    north, east = seabed_map(scene.seabed_m, rotation, centre, scene.intrinsics, g)
    return View(
        g,
        north - rows.BIAS,
        east - rows.BIAS,
        _transmission_nodes(g, scene, attenuation, window),
        np.empty((0, 0, 0), np.float32),
        outlines(scene.faces, scene.layout, rotation, centre, scene.intrinsics),
    )


@njit(cache=True, nogil=True, error_model="numpy")
def padded_columns(x0: int, x1: int) -> tuple[int, int]:
    """Return start and width of the rows to compute for the columns x0..x1."""
    start = (x0 + MARGIN) // NODE * NODE - MARGIN
    return start, (x1 - start + CHUNK - 1) // CHUNK * CHUNK


@njit(cache=True, nogil=True, error_model="numpy")
def render_strip(
    view: View,
    row: int,
    columns: tuple[int, int],
    scene: Scene,
    channel: Channel,
    buffers: Buffers,
    light: Row,
) -> None:
    """Write the radiance [grey] of a strip of rows, (rows * width,), from `row` on.

    `columns` is the window's first column and the one after its last.
    """
    start, width = padded_columns(columns[0], columns[1])
    n = light.shape[0]
    from_node = (row + MARGIN, start + MARGIN, width)
    shift = (view.north, view.east)
    rows.seabed_light(channel.seabed, view.ground, (row, start, width), shift, light)
    gain = buffers.gain[1, :0]
    if view.lamp.shape[0]:
        transmission = buffers.transmission[:n]
        ground_gain = buffers.gain[0, :n]
        gain = buffers.gain[1, :n]
        rows.interpolate_nodes(view.nodes, from_node, transmission)
        rows.interpolate_nodes(view.lamp[0], from_node, ground_gain)
        rows.interpolate_nodes(view.lamp[1], from_node, gain)
        rows.illuminate(light, ground_gain, transmission, channel.veil)
    else:
        rows.attenuate(view.nodes, from_node, channel.veil, light)
    extent = (row, start, width, columns[0], columns[1])
    draw_faces(view.outlines, extent, scene, channel, buffers, light, gain)


@njit(cache=True, nogil=True, error_model="numpy")
def fetch_noise(
    extent: tuple[int, int, int, int],
    height: int,
    grain: SensorNoise,
    noise_key: tuple[int, int],
) -> None:
    """Ask for the noise of a strip of `height` rows; the other arguments as for `expose_strip`.

    Its rows start anywhere in the bank, which other data displace from the cache between images.
    Rendering the strip gives the memory time to answer.
    """
    row, start, x0, x1 = extent
    width = padded_columns(x0, x1)[1]
    for r in range(row, row + height):
        first = noise_start(grain.seed, noise_key[0], r, noise_key[1]) + start
        for at in range(first, first + width, WIDTH):
            prefetch(grain.bank, at)
        prefetch(grain.bank, first + width - 1)  # rows rarely begin where a cache line does


@uncounted
def expose_strip(
    light: Row,
    extent: tuple[int, int, int, int],
    grain: SensorNoise,
    noise_key: tuple[int, int],
    levels: NDArray[np.uint8],
    out: NDArray[np.uint8],
) -> None:
    """Write the grey values of a strip's window into the image.

    `extent` is row and column of the first pixel and the columns of the window; `noise_key` the
    numbers of frame and channel.
    """
    row, start, x0, x1 = extent
    width = padded_columns(x0, x1)[1]
    blocks = width // WIDTH, WIDTH
    for r in range(light.shape[0] // width):
        first = noise_start(grain.seed, noise_key[0], row + r, noise_key[1]) + start
        noise = grain.bank[first : first + width].reshape(blocks)
        part = light[r * width : (r + 1) * width].reshape(blocks)
        rows.expose(part, noise, grain.read_variance, grain.shot_gain, levels[:width])
        rows.copy(levels[x0 - start : x1 - start], out[row + r, x0:x1])


@njit(cache=True, nogil=True, error_model="numpy")
def draw(
    pose: Array,
    scene: Scene,
    channel: Channel,
    grain: SensorNoise,
    frame: int,
    window: Window,
    buffers: Buffers,
    out: NDArray[np.uint8],
) -> None:
    """Render the window x0, y0, x1, y1 of one channel into `out` (H, W) uint8."""
    x0, y0, x1, y1 = window
    view = view_from(pose, scene, channel.attenuation, window)
    start, width = padded_columns(x0, x1)
    height = max(1, STRIP // width)
    for row in range(y0, y1, height):
        light = buffers.light[: min(height, y1 - row) * width]
        extent, noise_key = (row, start, x0, x1), (frame, channel.number)
        fetch_noise(extent, light.shape[0] // width, grain, noise_key)
        render_strip(view, row, (x0, x1), scene, channel, buffers, light)
        expose_strip(light, extent, grain, noise_key, buffers.levels, out)
