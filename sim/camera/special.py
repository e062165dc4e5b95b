"""Pictures with effects: light over the time of exposure, blurred, with what is in the way.

A plane of light is drawn for the window and a margin for the blur; then it is exposed like every
picture. A pixel does not depend on the window that it is drawn with.
"""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.camera.effects import Disturbance
from seamark.sim.camera.fish import add_fish
from seamark.sim.camera.geometry import camera_pose
from seamark.sim.camera.light import light_nodes
from seamark.sim.camera.raycast import View, columns_of, expose_strip, light_strip, view_of
from seamark.sim.camera.rows import CHUNK, spread
from seamark.sim.camera.scene import MARGIN, STRIP, Channel, Grain, Scene, Work
from seamark.sim.camera.snow import add_snow
from seamark.sim.numerics.libm import exp, sincos

Array = NDArray[np.float64]
Plane = NDArray[np.float32]
Window = tuple[int, int, int, int]

MOST_EXPOSURES = 16
WIDEST_BLUR_PX = 10.0  # [px] sigma; three of them fit into the margin
_F = np.float32


@njit(cache=True, nogil=True, error_model="numpy")
def moved(motion: Array, seconds: float) -> Array:
    """Return the pose (6,) a short time later; `motion` (12,) is pose and body velocities."""
    sr, cr = sincos(motion[3])
    sp, cp = sincos(motion[4])
    sy, cy = sincos(motion[5])
    u, v, w = motion[6], motion[7], motion[8]
    p, q, r = motion[9], motion[10], motion[11]
    rate = np.empty(6)
    rate[0] = cy * cp * u + (cy * sp * sr - sy * cr) * v + (cy * sp * cr + sy * sr) * w
    rate[1] = sy * cp * u + (sy * sp * sr + cy * cr) * v + (sy * sp * cr - cy * sr) * w
    rate[2] = -sp * u + cp * sr * v + cp * cr * w
    turn = q * sr + r * cr
    steep = cp if abs(cp) > 0.05 else 0.05
    rate[3] = p + turn * sp / steep
    rate[4] = q * cr - r * sr
    rate[5] = turn / steep
    pose = np.empty(6)
    for k in range(6):
        pose[k] = motion[k] + seconds * rate[k]
    return pose


@njit(cache=True, nogil=True, error_model="numpy")
def exposures(motion: Array, scene: Scene, light: Disturbance) -> int:
    """Return how many poses make a blurred picture: no two farther apart than about a pixel."""
    height = max(scene.seabed_m - motion[2] - scene.mount[2], 0.3)
    speed = (abs(motion[6]) + abs(motion[7]) + abs(motion[8])) / height
    turn = abs(motion[9]) + abs(motion[10]) + abs(motion[11])
    pixels = scene.intrinsics[0] * (speed + turn) * light.exposure_s
    return int(min(np.ceil(pixels) + 1.0, float(MOST_EXPOSURES))) if pixels > 0.02 else 1


@njit(cache=True, nogil=True, error_model="numpy")
def blur_sigma(view: View, scene: Scene, channel: Channel, light: Disturbance) -> float:
    """Return the blur of forward scatter [px] for the optical depth along the camera's axis."""
    if light.scatter == 0.0:
        return 0.0
    f, u, v = scene.intrinsics[0], scene.intrinsics[1], scene.intrinsics[2]
    g = view.ground
    path = channel.attenuation / max(g[2, 0] * u + g[2, 1] * v + g[2, 2], 1e-3)
    if scene.fog:
        path = path * path
    return float(min(light.scatter * path * f, WIDEST_BLUR_PX))


@njit(cache=True, nogil=True, error_model="numpy")
def _weights(sigma: float) -> Plane:
    """Return half a normalised Gaussian: the weight of the middle, then of each step outwards."""
    reach = int(np.ceil(3.0 * sigma))
    found = np.empty(reach + 1)
    total = 0.0
    for k in range(reach + 1):
        found[k] = exp(-0.5 * (k / sigma) * (k / sigma))
        total += found[k] if k == 0 else 2.0 * found[k]
    out = np.empty(reach + 1, np.float32)
    for k in range(reach + 1):
        out[k] = _F(found[k] / total)
    return out


@njit(cache=True, nogil=True, error_model="numpy")
def blurred(plane: Plane, sigma: float) -> Plane:
    """Return a plane under a Gaussian; its rim of three sigma is of no use."""
    weights = _weights(sigma)
    reach = weights.shape[0] - 1
    height, width = plane.shape
    across = plane.copy()
    for r in range(height):
        for c in range(reach, width - reach):
            total = weights[0] * plane[r, c]
            for k in range(1, reach + 1):
                total += weights[k] * (plane[r, c - k] + plane[r, c + k])
            across[r, c] = total
    out = across.copy()
    for r in range(reach, height - reach):
        for c in range(width):
            total = weights[0] * across[r, c]
            for k in range(1, reach + 1):
                total += weights[k] * (across[r - k, c] + across[r + k, c])
            out[r, c] = total
    return out


@njit(cache=True, nogil=True, error_model="numpy")
def _lit(
    view: View,
    scene: Scene,
    channel: Channel,
    light: Disturbance,
    window: Window,
    eye: tuple[Array, Array],
    time_s: float,
) -> View:
    """Return the view with the light at its nodes."""
    g, u, v = view.ground, scene.intrinsics[1], scene.intrinsics[2]
    depth = 1.0 / max(g[2, 0] * u + g[2, 1] * v + g[2, 2], 1e-3)
    nearer = max(1.0 - (scene.seabed_m - scene.faces[0, 2]) / depth, 0.05)
    nodes = light_nodes(g, scene, (channel.attenuation, nearer), light, window, eye, time_s)
    return View(view.ground, view.north, view.east, view.nodes, nodes, view.outlines)


@njit(cache=True, nogil=True, error_model="numpy")
def _instant(
    view: View,
    window: Window,
    scene: Scene,
    channel: Channel,
    light: Disturbance,
    work: Work,
    plane: Plane,
) -> None:
    """Write the light of the window at one instant into a plane (rows, columns)."""
    x0, y0, x1, _ = window
    width = plane.shape[1]
    flat = plane.ravel()
    height = max(1, STRIP // width)
    for row in range(0, plane.shape[0], height):
        part = flat[row * width : min(row + height, plane.shape[0]) * width]
        light_strip(view, y0 + row, (x0, x1), scene, channel, work, part)
        if light.lamp > 0.0:
            glow = work.gain[0, : part.shape[0]]
            start = columns_of(x0, x1)[0]
            spread(view.lamp[2], (y0 + row + MARGIN, start + MARGIN, width), glow)
            for q in range(part.shape[0]):
                part[q] += _F(255.0) * glow[q]


@njit(cache=True, nogil=True, error_model="numpy")
def _exposed(
    motion: Array,
    scene: Scene,
    channel: Channel,
    light: Disturbance,
    frame: int,
    window: Window,
    size: tuple[int, int],
    work: Work,
) -> Plane:
    """Return the mean light of the window (rows, columns) over the exposure."""
    start, width = columns_of(window[0], window[2])
    corner = (window[1], start)
    mean = np.zeros((window[3] - window[1], width), np.float32)
    plane = np.empty_like(mean)
    count = exposures(motion, scene, light)
    rotation, centre = np.empty((3, 3)), np.empty(3)
    for k in range(count):
        later = light.exposure_s * ((k + 0.5) / count - 0.5)
        pose = moved(motion, later)
        view = view_of(pose, scene, channel.attenuation, window)
        camera_pose(pose, scene.mount, rotation, centre)
        eye = (rotation, centre)
        time_s = frame * light.frame_s + later
        if light.lit:
            view = _lit(view, scene, channel, light, window, eye, time_s)
        _instant(view, window, scene, channel, light, work, plane)
        if light.fish > 0.0:
            add_fish(plane, corner, eye, scene, channel, light, time_s)
        if light.snow > 0.0:
            add_snow(plane, corner, size, eye, scene, channel, light, time_s)
        share = _F(1.0 / count)
        for r in range(mean.shape[0]):
            for c in range(width):
                mean[r, c] += share * plane[r, c]
    return mean


@njit(cache=True, nogil=True, error_model="numpy")
def draw(
    motion: Array,
    scene_of: tuple[Any, ...],
    channel_of: tuple[Any, ...],
    grain: tuple[Any, ...],
    disturbance: tuple[Any, ...],
    shot: tuple[int, Window],
    work_of: tuple[Any, ...],
    out: NDArray[np.uint8],
) -> None:
    """Draw a window of one channel with effects into `out` (H, W) uint8.

    The tuples are those of `raycast.draw`; `motion` (12,) is pose and body velocities, `shot` the
    number of the frame and the window.
    """
    scene, work, light = Scene(*scene_of), Work(*work_of), Disturbance(*disturbance)
    plain = Channel(*channel_of)
    veil = plain.veil * light.level
    channel = Channel(plain.tile, plain.skin, plain.attenuation, veil, plain.number)
    frame, (x0, y0, x1, y1) = shot
    size = (out.shape[1], out.shape[0])
    sigma = blur_sigma(
        view_of(motion[:6], scene, channel.attenuation, (0, 0, 1, 1)), scene, channel, light
    )
    reach = int(np.ceil(3.0 * sigma))
    # A CHUNK more to the right: the window's rows may end later than those of the wider one.
    wider = (x0 - reach, y0 - reach, x1 + reach + CHUNK, y1 + reach)
    plane = _exposed(motion, scene, channel, light, frame, wider, size, work)
    if reach > 0:
        plane = blurred(plane, sigma)
    start, width = columns_of(x0, x1)
    skip = start - columns_of(wider[0], wider[2])[0]
    for row in range(y0, y1):
        part = plane[row - wider[1], skip : skip + width]
        stamp = (frame, channel.number)
        expose_strip(part, (row, start, x0, x1), Grain(*grain), stamp, work.levels, out)
