"""Renders what a camera on a link sees with motion blur, forward scatter and marine snow.

As `raycast_effects` does: a plane of radiance for the window and a margin for the blur, then noise.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.camera.body_rows import depths
from seamark.sim.camera.effects import LAMP_FORWARD_M, EffectParameters
from seamark.sim.camera.instant import Instant, Links, Stage, Tones, Window, axes_of, instant_at
from seamark.sim.camera.link_raycast import Memory, render_rows
from seamark.sim.camera.open_seabed import LEAST
from seamark.sim.camera.raycast import expose_strip, padded_columns
from seamark.sim.camera.raycast_effects import MAX_EXPOSURES, WIDEST_BLUR_PX, gaussian_blur
from seamark.sim.camera.rows import CHUNK
from seamark.sim.camera.scene import STRIP, Channel, SensorNoise
from seamark.sim.camera.sightings import Sight, attached_axes
from seamark.sim.camera.snow import Eye, Painting, add_snow
from seamark.sim.camera.visibility import nearest_hit
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.libm import sincos

Plane = NDArray[np.float32]

_CLOSE_M = 0.05  # what is nearer does not count for the number of exposures
_REACH_M = 6.0  # and of the seabed no more than this, along the optical axis
_F = np.float32


@njit(cache=True, nogil=True, error_model="numpy")
def links_after(placed: Links, seconds: float) -> Links:
    """Return where links are a short time later: each turns about its origin, which moves."""
    rotation, position, twist = placed
    turned, moved = np.empty_like(rotation), position.copy()
    step = np.empty((3, 3))
    for k in range(rotation.shape[0]):
        x, y, z = twist[k, 3], twist[k, 4], twist[k, 5]
        speed = np.sqrt(x * x + y * y + z * z)
        s, c = sincos(speed * seconds)
        if speed > 0.0:
            x, y, z = x / speed, y / speed, z / speed
        d = 1.0 - c
        step[0, 0], step[0, 1], step[0, 2] = c + x * x * d, x * y * d - z * s, x * z * d + y * s
        step[1, 0], step[1, 1], step[1, 2] = x * y * d + z * s, c + y * y * d, y * z * d - x * s
        step[2, 0], step[2, 1], step[2, 2] = x * z * d - y * s, y * z * d + x * s, c + z * z * d
        for i in range(3):
            for j in range(3):
                moved[k, i] += seconds * rotation[k, i, j] * twist[k, j]
                turned[k, i, j] = 0.0
                for m in range(3):
                    turned[k, i, j] += rotation[k, i, m] * step[m, j]
    return turned, moved, twist


@njit(cache=True, nogil=True, error_model="numpy")
def _in_view(sight: Sight, point: Array) -> tuple[float, float, float]:
    """Return a point of the world in the axes of a camera."""
    x, y, z = 0.0, 0.0, 0.0
    for j in range(3):
        d = point[j] - sight.centre[j]
        x += sight.axes[0, j] * d
        y += sight.axes[1, j] * d
        z += sight.axes[2, j] * d
    return x, y, z


@njit(cache=True, nogil=True, error_model="numpy")
def _shift(first: Sight, last: Sight, begin: Array, end: Array, focal: float) -> float:
    """Return how far the image of a point moves [px]; 0 where it is too close or behind."""
    ax, ay, az = _in_view(first, begin)
    bx, by, bz = _in_view(last, end)
    if az < _CLOSE_M or bz < _CLOSE_M:
        return 0.0
    return float(focal * max(abs(ax / az - bx / bz), abs(ay / az - by / bz)))


@njit(cache=True, nogil=True, error_model="numpy")
def exposure_count(placed: Links, stage: Stage, size: tuple[int, int], exposure_s: float) -> int:
    """Return the number of instants for motion blur: adjacent ones are about a pixel apart.

    From the seabed at the corners and the middle of the image, and from the ends of bodies.
    """
    if exposure_s == 0.0:
        return 1
    begin = links_after(placed, -0.5 * exposure_s)
    end = links_after(placed, 0.5 * exposure_s)
    sight = axes_of(placed, stage.camera)
    first, last = axes_of(begin, stage.camera), axes_of(end, stage.camera)
    f, u0, v0 = stage.scene.intrinsics[0], stage.scene.intrinsics[1], stage.scene.intrinsics[2]
    pixels = 0.0
    point, other = np.empty(3), np.empty(3)
    for k in range(5):
        x = (size[0] * (k % 2) - u0) / f if k < 4 else 0.0
        y = (size[1] * (k // 2) - v0) / f if k < 4 else 0.0
        for j in range(3):
            point[j] = sight.axes[0, j] * x + sight.axes[1, j] * y + sight.axes[2, j]
        height = max(stage.scene.seabed_m - sight.centre[2], _CLOSE_M)
        depth = min(height / point[2], _REACH_M) if point[2] > 0.0 else _REACH_M
        for j in range(3):
            point[j] = sight.centre[j] + depth * point[j]
        pixels = max(pixels, _shift(first, last, point, point, f))
    shapes = stage.shapes
    for k in range(shapes.kind.shape[0]):
        link, centre, turn = shapes.link[k], shapes.centre[k], shapes.turn[k]
        axes, origin = attached_axes(begin[0], begin[1], link, centre, turn)
        later, there = attached_axes(end[0], end[1], link, centre, turn)
        for way in range(6):
            reach = shapes.half[k, way // 2] * (1.0 if way % 2 else -1.0)
            for j in range(3):
                point[j] = origin[j] + axes[j, way // 2] * reach
                other[j] = there[j] + later[j, way // 2] * reach
            pixels = max(pixels, _shift(first, last, point, other, f))
    return int(min(np.ceil(pixels) + 1.0, float(MAX_EXPOSURES))) if pixels > 0.02 else 1


@njit(cache=True, nogil=True, error_model="numpy")
def depth_ahead(instant: Instant) -> float:
    """Return the depth of what the middle of the image shows [m]."""
    g, u, v = instant.ground.map, instant.lens[1], instant.lens[2]
    seabed = 1.0 / max(g[2, 0] * u + g[2, 1] * v + g[2, 2], LEAST)
    return float(min(seabed, nearest_hit(instant, 0.0, 0.0)))


@njit(cache=True, nogil=True, error_model="numpy")
def blur_sigma(
    placed: Links, stage: Stage, tones: Tones, effects: EffectParameters, size: tuple[int, int]
) -> float:
    """Return the blur of forward scatter [px] for the optical depth along the camera's axis."""
    if effects.scatter == 0.0:
        return 0.0
    instant = instant_at(placed, stage, tones, effects, (0, 0, size[0], size[1]), 0.0)
    path = tones.channel.attenuation * depth_ahead(instant)
    if stage.scene.fog:
        path = path * path
    return float(min(effects.scatter * path * stage.scene.intrinsics[0], WIDEST_BLUR_PX))


@njit(cache=True, nogil=True, error_model="numpy")
def _render_instant(
    instant: Instant,
    window: Window,
    tones: Tones,
    memory: Memory,
    plane: Plane,
    depth: Plane,
) -> None:
    """Write the radiance of the window at one instant, and depths if there is a plane for them."""
    x0, y0, x1, _ = window
    width = plane.shape[1]
    flat = plane.ravel()
    height = max(1, STRIP // width)
    known = depth.shape[0] > 0
    for row in range(0, plane.shape[0], height):
        end = min(row + height, plane.shape[0])
        part = flat[row * width : end * width]
        render_rows(instant, y0 + row, (x0, x1), tones, memory, part, known)
        if known:
            depth[row:end] = depths(memory.layers, end - row, width)


@njit(cache=True, nogil=True, error_model="numpy")
def _average_exposure(
    placed: Links,
    stage: Stage,
    tones: Tones,
    effects: EffectParameters,
    frame_window: tuple[int, Window],
    size: tuple[int, int],
    memory: Memory,
) -> Plane:
    """Return the mean radiance of the window (rows, columns) over the exposure."""
    frame, window = frame_window
    start, width = padded_columns(window[0], window[2])
    mean = np.zeros((window[3] - window[1], width), np.float32)
    plane = np.empty_like(mean)
    depth = np.empty((mean.shape[0] if effects.snow > 0.0 else 0, width), np.float32)
    count = exposure_count(placed, stage, size, effects.exposure_s)
    dimmed = tones.channel
    veiled = Channel(
        dimmed.seabed,
        dimmed.box_texture,
        dimmed.attenuation,
        dimmed.veil * effects.level,
        dimmed.number,
    )
    share = _F(1.0 / count)
    for k in range(count):
        later = effects.exposure_s * ((k + 0.5) / count - 0.5)
        links = links_after(placed, later) if later != 0.0 else placed
        time_s = frame * effects.frame_s + later
        instant = instant_at(links, stage, tones, effects, window, time_s)
        _render_instant(instant, window, tones, memory, plane, depth)
        if effects.snow > 0.0:
            sight, lamp = instant.sight, axes_of(links, stage.lamp)
            eye = Eye(sight.axes, sight.centre)
            beside = Eye(lamp.axes, lamp.centre + LAMP_FORWARD_M * lamp.axes[1])
            painting = Painting(plane, (window[1], start), size, depth)
            add_snow(painting, (eye, beside), stage.scene, veiled, effects, time_s)
        for r in range(mean.shape[0]):
            for c in range(width):
                mean[r, c] += share * plane[r, c]
    return mean


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
    """Render a window of one channel with effects into `out` (H, W) uint8."""
    frame, (x0, y0, x1, y1) = frame_window
    size = (out.shape[1], out.shape[0])
    sigma = blur_sigma(placed, stage, tones, effects, size)
    reach = int(np.ceil(3.0 * sigma))
    # One CHUNK more on the right: rows of the window may end later than those of the wider one.
    wider = (x0 - reach, y0 - reach, x1 + reach + CHUNK, y1 + reach)
    plane = _average_exposure(placed, stage, tones, effects, (frame, wider), size, memory)
    if reach > 0:
        plane = gaussian_blur(plane, sigma)
    start, width = padded_columns(x0, x1)
    skip = start - padded_columns(wider[0], wider[2])[0]
    noise_key = (frame, tones.channel.number)
    for row in range(y0, y1):
        part = plane[row - wider[1], skip : skip + width]
        expose_strip(part, (row, start, x0, x1), grain, noise_key, memory.strip.levels, out)
