"""A camera on a link at one instant: where it is, what is in view, and how it is lit."""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.camera.bodies import Paints, Shapes
from seamark.sim.camera.effects import EffectParameters
from seamark.sim.camera.lighting import Lighting, Point, lighting_of, seabed_nodes
from seamark.sim.camera.open_seabed import Ground, ground_from
from seamark.sim.camera.scene import Channel, Scene
from seamark.sim.camera.sightings import Seen, Sight, attached_axes, bodies_seen, sight_along
from seamark.sim.numerics.arrays import Array

Links = tuple[Array, Array, Array]  # rotations (n, 3, 3), positions (n, 3), twists (n, 6)
Window = tuple[int, int, int, int]


class Mount(NamedTuple):
    """Axes on a link: a camera or a lamp looks along the first one, the third is down."""

    link: int
    point: Array  # (3,) [m]
    turn: Array  # (3, 3)


class Stage(NamedTuple):
    """What all images have in common."""

    scene: Scene  # without a box
    shapes: Shapes
    camera: Mount
    lamp: Mount


class Tones(NamedTuple):
    """What belongs to one colour channel."""

    channel: Channel
    paints: Paints
    mean: float  # [grey] of the seabed's texture


class Instant(NamedTuple):
    """The scene at one instant."""

    sight: Sight
    ground: Ground
    seen: Seen
    lighting: Lighting
    nodes: NDArray[np.float32]  # (rows, columns) light on the seabed; or empty
    lens: Point  # focal length, principal column, principal row [px]


@njit(cache=True, nogil=True, error_model="numpy")
def axes_of(placed: Links, mount: Mount) -> Sight:
    """Return where a camera or a lamp is; `placed` is where the links are."""
    axes, origin = attached_axes(placed[0], placed[1], mount.link, mount.point, mount.turn)
    return sight_along(axes, origin)


@njit(cache=True, nogil=True, error_model="numpy")
def instant_at(
    placed: Links,
    stage: Stage,
    tones: Tones,
    effects: EffectParameters,
    window: Window,
    time_s: float,
) -> Instant:
    """Return the scene for a window of the image."""
    scene = stage.scene
    sight = axes_of(placed, stage.camera)
    lamp = axes_of(placed, stage.lamp)
    lighting = lighting_of(
        tones.channel, scene.fog, effects, (lamp.centre, lamp.axes[2]), (sight.axes, sight.centre)
    )
    ground = ground_from(sight, scene.seabed_m, tones.mean, scene.intrinsics)
    seen = bodies_seen(
        sight,
        (placed[0], placed[1]),
        stage.shapes,
        tones.paints,
        lighting,
        scene.intrinsics,
        window,
    )
    nodes = np.empty((0, 0), np.float32)
    if effects.lamp > 0.0 or effects.waves.shape[0] > 0:
        nodes = seabed_nodes(
            ground.map, (sight.axes, sight.centre), scene, lighting, effects, window, time_s
        )
    lens = scene.intrinsics[0], scene.intrinsics[1], scene.intrinsics[2]
    return Instant(sight, ground, seen, lighting, nodes, lens)
