"""Renders images with effects: light, motion blur, forward scatter, fish and marine snow.

A plane of radiance is rendered for the window and a margin for the blur; noise is then added as for
every image. A pixel does not depend on the window that it is rendered in.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.camera.effects import EffectParameters
from seamark.sim.camera.fish import add_fish
from seamark.sim.camera.geometry import camera_pose
from seamark.sim.camera.light import light_nodes
from seamark.sim.camera.raycast import View, expose_strip, padded_columns, render_strip, view_from
from seamark.sim.camera.rows import CHUNK, interpolate_nodes
from seamark.sim.camera.scene import MARGIN, STRIP, Buffers, Channel, Scene, SensorNoise
from seamark.sim.camera.snow import Eye, Painting, add_snow
from seamark.sim.numerics.libm import exp, sincos

Array = NDArray[np.float64]
Plane = NDArray[np.float32]
Window = tuple[int, int, int, int]

MAX_EXPOSURES = 16
WIDEST_BLUR_PX = 10.0  # [px] sigma; three of them fit into the margin
_F = np.float32


@njit(cache=True, nogil=True, error_model="numpy")
def pose_after(motion: Array, seconds: float) -> Array:
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
def scene_after(scene: Scene, drift: Array, seconds: float) -> Scene:
    """Return the scene a short time later: a target that moves by itself has moved its faces."""
    if drift[2] == 0.0 and drift[3] == 0.0 and drift[4] == 0.0:
        return scene
    s, c = sincos(drift[4] * seconds)
    faces = scene.faces.copy()
    for face in faces:
        face[0] -= drift[0]
        face[1] -= drift[1]
        for at in range(0, 12, 3):  # first corner, two edges, normal
            north, east = face[at], face[at + 1]
            face[at] = c * north - s * east
            face[at + 1] = s * north + c * east
        face[0] += drift[0] + drift[2] * seconds
        face[1] += drift[1] + drift[3] * seconds
    return Scene(scene.intrinsics, scene.mount, scene.seabed_m, faces, scene.layout, scene.fog)


@njit(cache=True, nogil=True, error_model="numpy")
def exposure_count(motion: Array, scene: Scene, effects: EffectParameters) -> int:
    """Return the number of poses for motion blur: adjacent ones are about a pixel apart."""
    height = max(scene.seabed_m - motion[2] - scene.mount[2], 0.3)
    speed = (abs(motion[6]) + abs(motion[7]) + abs(motion[8])) / height
    turn = abs(motion[9]) + abs(motion[10]) + abs(motion[11])
    speed += (abs(effects.drift[2]) + abs(effects.drift[3])) / height
    turn += abs(effects.drift[4])
    pixels = scene.intrinsics[0] * (speed + turn) * effects.exposure_s
    return int(min(np.ceil(pixels) + 1.0, float(MAX_EXPOSURES))) if pixels > 0.02 else 1


@njit(cache=True, nogil=True, error_model="numpy")
def blur_sigma(view: View, scene: Scene, channel: Channel, effects: EffectParameters) -> float:
    """Return the blur of forward scatter [px] for the optical depth along the camera's axis."""
    if effects.scatter == 0.0:
        return 0.0
    f, u, v = scene.intrinsics[0], scene.intrinsics[1], scene.intrinsics[2]
    g = view.ground
    path = channel.attenuation / max(g[2, 0] * u + g[2, 1] * v + g[2, 2], 1e-3)
    if scene.fog:
        path = path * path
    return float(min(effects.scatter * path * f, WIDEST_BLUR_PX))


@njit(cache=True, nogil=True, error_model="numpy")
def _weights(sigma: float) -> Plane:
    """Return half a normalised Gaussian: the central weight, then the next ones outwards."""
    reach = int(np.ceil(3.0 * sigma))
    bell = np.empty(reach + 1)
    total = 0.0
    for k in range(reach + 1):
        bell[k] = exp(-0.5 * (k / sigma) * (k / sigma))
        total += bell[k] if k == 0 else 2.0 * bell[k]
    out = np.empty(reach + 1, np.float32)
    for k in range(reach + 1):
        out[k] = _F(bell[k] / total)
    return out


@njit(cache=True, nogil=True, error_model="numpy")
def gaussian_blur(plane: Plane, sigma: float) -> Plane:
    """Return a plane blurred by a Gaussian; its margin of three sigma is invalid."""
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
def _with_light(
    view: View,
    scene: Scene,
    channel: Channel,
    effects: EffectParameters,
    window: Window,
    extrinsics: tuple[Array, Array],
    time_s: float,
) -> View:
    """Return the view with the light at its nodes."""
    g, u, v = view.ground, scene.intrinsics[1], scene.intrinsics[2]
    depth = 1.0 / max(g[2, 0] * u + g[2, 1] * v + g[2, 2], 1e-3)
    nearer = 1.0
    if scene.faces.shape[0]:
        nearer = max(1.0 - (scene.seabed_m - scene.faces[0, 2]) / depth, 0.05)
    nodes = light_nodes(
        g, scene, (channel.attenuation, nearer), effects, window, extrinsics, time_s
    )
    return View(view.ground, view.north, view.east, view.nodes, nodes, view.outlines)


@njit(cache=True, nogil=True, error_model="numpy")
def _render_instant(
    view: View,
    window: Window,
    scene: Scene,
    channel: Channel,
    effects: EffectParameters,
    buffers: Buffers,
    plane: Plane,
) -> None:
    """Write the radiance of the window at one instant to a plane (rows, columns)."""
    x0, y0, x1, _ = window
    width = plane.shape[1]
    flat = plane.ravel()
    height = max(1, STRIP // width)
    for row in range(0, plane.shape[0], height):
        part = flat[row * width : min(row + height, plane.shape[0]) * width]
        render_strip(view, y0 + row, (x0, x1), scene, channel, buffers, part)
        if effects.lamp > 0.0:
            glow = buffers.gain[0, : part.shape[0]]
            start = padded_columns(x0, x1)[0]
            interpolate_nodes(view.lamp[2], (y0 + row + MARGIN, start + MARGIN, width), glow)
            for q in range(part.shape[0]):
                part[q] += _F(255.0) * glow[q]


@njit(cache=True, nogil=True, error_model="numpy")
def _average_exposure(
    motion: Array,
    scene: Scene,
    channel: Channel,
    effects: EffectParameters,
    frame: int,
    window: Window,
    size: tuple[int, int],
    buffers: Buffers,
) -> Plane:
    """Return the mean radiance of the window (rows, columns) over the exposure."""
    start, width = padded_columns(window[0], window[2])
    corner = (window[1], start)
    mean = np.zeros((window[3] - window[1], width), np.float32)
    plane, open_water = np.empty_like(mean), np.empty((0, 0), np.float32)
    count = exposure_count(motion, scene, effects)
    rotation, centre = np.empty((3, 3)), np.empty(3)
    for k in range(count):
        later = effects.exposure_s * ((k + 0.5) / count - 0.5)
        pose = pose_after(motion, later)
        now = scene_after(scene, effects.drift, later)
        view = view_from(pose, now, channel.attenuation, window)
        camera_pose(pose, scene.mount, rotation, centre)
        extrinsics = (rotation, centre)
        time_s = frame * effects.frame_s + later
        if effects.alters_light:
            view = _with_light(view, now, channel, effects, window, extrinsics, time_s)
        _render_instant(view, window, now, channel, effects, buffers, plane)
        if effects.fish > 0.0:
            add_fish(plane, corner, extrinsics, now, channel, effects, time_s)
        if effects.snow > 0.0:
            eye = Eye(rotation, centre)
            painting = Painting(plane, corner, size, open_water)
            add_snow(painting, (eye, eye), now, channel, effects, time_s)
        share = _F(1.0 / count)
        for r in range(mean.shape[0]):
            for c in range(width):
                mean[r, c] += share * plane[r, c]
    return mean


@njit(cache=True, nogil=True, error_model="numpy")
def draw(
    motion: Array,
    scene: Scene,
    plain: Channel,
    grain: SensorNoise,
    effects: EffectParameters,
    frame_window: tuple[int, Window],
    buffers: Buffers,
    out: NDArray[np.uint8],
) -> None:
    """Render a window of one channel with effects into `out` (H, W) uint8.

    `motion` (12,) is the pose and the body velocities, `plain` the channel in daylight,
    `frame_window` the frame number and the window.
    """
    veil = plain.veil * effects.level
    channel = Channel(plain.seabed, plain.box_texture, plain.attenuation, veil, plain.number)
    frame, (x0, y0, x1, y1) = frame_window
    size = (out.shape[1], out.shape[0])
    sigma = blur_sigma(
        view_from(motion[:6], scene, channel.attenuation, (0, 0, 1, 1)), scene, channel, effects
    )
    reach = int(np.ceil(3.0 * sigma))
    # One CHUNK more on the right: rows of the window may end later than those of the wider one.
    wider = (x0 - reach, y0 - reach, x1 + reach + CHUNK, y1 + reach)
    plane = _average_exposure(motion, scene, channel, effects, frame, wider, size, buffers)
    if reach > 0:
        plane = gaussian_blur(plane, sigma)
    start, width = padded_columns(x0, x1)
    skip = start - padded_columns(wider[0], wider[2])[0]
    for row in range(y0, y1):
        part = plane[row - wider[1], skip : skip + width]
        noise_key = (frame, channel.number)
        expose_strip(part, (row, start, x0, x1), grain, noise_key, buffers.levels, out)
