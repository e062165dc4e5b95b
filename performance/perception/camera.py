"""Images of our camera compared with PyBullet's TinyRenderer, which has no water or noise.

What an arm and things in the image cost is compared with the same image without them.
"""

from collections.abc import Callable
from functools import partial

import numpy as np
import pybullet

from performance.perception.arm_scene import arm_scene, cameras
from performance.tables import Row, cpu_us
from seamark.sim.camera import CURRENTS, VISIBILITY, Camera, Optics, Target, Water, start_pose

_HEIGHTS_M = {"320x240": (VISIBILITY, 1.27), "640x480": (CURRENTS, 2.27)}
_MARGIN_PX = 20


def rows() -> list[Row]:
    """Measure and return the rows."""
    return [
        row
        for size, (optics, height_m) in _HEIGHTS_M.items()
        for row in _rows_of(size, optics, height_m)
    ] + _rows_with_bodies()


def _rows_of(size: str, optics: Optics, height_m: float) -> list[Row]:
    target = Target()
    camera = Camera(optics, Water(), target, noise_seed=1)
    pose = np.asarray(start_pose(optics, target, height_m))
    corners = camera.corners(pose)
    x0, y0 = (int(low) - _MARGIN_PX for low in corners.min(axis=0))
    x1, y1 = (int(high) + _MARGIN_PX for high in corners.max(axis=0))
    calls: dict[str, Callable[[], object]] = {
        f"target's window {x1 - x0}x{y1 - y0} of {size}": lambda: camera.region(
            pose, 3, (x0, y0, x1, y1)
        ),
        f"grey image {size}": lambda: camera.grey(pose, 3),
        f"colour image {size}": lambda: camera.colour(pose, 3),
    }
    baseline_us = _tiny_renderer_us(optics, height_m)
    return [
        Row(
            what=what,
            value=cpu_us(call, inner=20),
            unit="us CPU",
            baseline=f"TinyRenderer {size}",
            baseline_value=baseline_us,
        )
        for what, call in calls.items()
    ]


def _rows_with_bodies() -> list[Row]:
    scene, water = arm_scene(), Water()
    count = len(scene.bodies.shapes.kind)
    pairs = zip(cameras(scene, water), cameras(scene, water, empty=True), strict=True)
    return [
        Row(
            what=f"grey image 320x240 {where}, {count} bodies",
            value=cpu_us(partial(camera.grey, scene.placed, 3), inner=20),
            unit="us CPU",
            baseline="the same without bodies",
            baseline_value=cpu_us(partial(empty.grey, scene.placed, 3), inner=20),
        )
        for where, (camera, empty) in zip(("on a vehicle", "on an arm"), pairs, strict=True)
    ]


def _tiny_renderer_us(optics: Optics, height_m: float) -> float:
    """Return the time to render a plane and a box from the same height, without shadows."""
    world = pybullet.connect(pybullet.DIRECT)
    try:
        for half, position in (
            ([8, 8, 0.05], [0, 0, -0.05]),
            ([0.21, 0.065, 0.065], [0, 0, 0.065]),
        ):
            shape = pybullet.createVisualShape(
                pybullet.GEOM_BOX, halfExtents=half, physicsClientId=world
            )
            pybullet.createMultiBody(
                0.0, baseVisualShapeIndex=shape, basePosition=position, physicsClientId=world
            )
        view = pybullet.computeViewMatrix([0, 0, height_m + 0.13], [0, 0, 0], [1, 0, 0])
        lens = pybullet.computeProjectionMatrixFOV(50.0, optics.width / optics.height, 0.1, 20.0)
        return cpu_us(
            lambda: pybullet.getCameraImage(
                optics.width,
                optics.height,
                view,
                lens,
                shadow=0,
                renderer=pybullet.ER_TINY_RENDERER,
                physicsClientId=world,
            ),
            repeats=5,
        )
    finally:
        pybullet.disconnect(world)
