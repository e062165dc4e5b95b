"""Images and trackers of many vehicles beside one by one, and beside renderers that do less.

Pictures are grey, 84 x 84 px, unless a row says otherwise. With a control period of 0.1 s an
environment draws an image at each step, and simulates ten physics steps, sensors and controllers
beside it. OpenCV warps a texture of sand onto the seabed and adds noise drawn anew: no box, no
water. PyBullet's TinyRenderer draws the seabed and the box in plain colours. Resets are not
included.
"""

import math
from collections.abc import Callable
from typing import Any

import cv2
import gymnasium
import numpy as np
import pybullet

import seamark.gym  # noqa: F401  # registers the environments
from performance.simulator.gym import Cost, compared, least, own_cores
from seamark.sim.camera import Camera, Optics, Target, Water, start_pose

_VEHICLES = 256
_NAME = "seamark/StationKeeping-v3"
_SIDE = 84
_HEAD = ("what runs", "a second", "wall time [µs]", "CPU time [µs]", "relative")
_OPTICS = Optics(width=_SIDE, height=_SIDE, focal_px=514.7 * _SIDE / 480)
_ALTITUDE_M = 2.0


def table() -> str:
    """Measure and return the table, in Markdown."""
    images = {"observation": "image", "settings": {"tracker": "truth", "control_period_s": 0.1}}
    costs = {
        f"images of {_VEHICLES} vehicles, two threads": _fleet(2, **images),
        "images, one thread": _fleet(1, **images),
        "images in colour, two threads": _fleet(2, **images, channels="rgb"),
        "images of 128 x 128 px, two threads": _fleet(2, **images, image_size=(128, 128)),
        "images with depth and segmentation, two threads": _fleet(
            2, **images | {"observation": "image+depth+segmentation"}
        ),
        "camera alone, one by one": _one_by_one(),
        "OpenCV, one by one: texture warped, noise added": _opencv(),
        "PyBullet's TinyRenderer, one by one: plain colours": _tiny_renderer(),
        f"control steps of {_VEHICLES} vehicles with camera and tracker, two threads": _fleet(2),
        "control steps with camera and tracker, one thread": _fleet(1),
        "control steps of the single environment with camera and tracker": _single(),
    }
    return compared(_HEAD, costs)


def _fleet(threads: int, **options: Any) -> Cost:
    env: Any = gymnasium.make_vec(_NAME, num_envs=_VEHICLES, threads=threads, **options)
    env.reset(seed=0)
    actions = np.zeros(env.action_space.shape)
    env.step(actions)  # starts the threads
    try:
        with own_cores():
            return least(lambda: env.step(actions), _VEHICLES, steps=20)
    finally:
        env.close()


def _single() -> Cost:
    env = gymnasium.make(_NAME).unwrapped
    env.reset(seed=0)
    action = np.zeros(4)
    try:
        return least(lambda: env.step(action), 1, steps=100)
    finally:
        env.close()


def _one_by_one() -> Cost:
    target = Target()
    camera = Camera(_OPTICS, Water(), target, noise_seed=1)
    pose = start_pose(_OPTICS, target, _ALTITUDE_M)
    return least(_counting(lambda frame: camera.grey(pose, frame)), 1, steps=200)


def _counting(call: Callable[[int], object]) -> Callable[[], object]:
    frames = iter(range(2**31))
    return lambda: call(next(frames))


def _opencv() -> Cost:
    random = np.random.default_rng(1)
    sand = random.integers(90, 130, (512, 512), np.uint8)
    view = np.array([[2.0, 0.1, 40.0], [-0.1, 2.0, 60.0], [1e-4, 0.0, 1.0]])
    noise, mean, sigma = np.empty((_SIDE, _SIDE), np.float32), np.array([0.5]), np.array([1.2])

    def draw() -> object:
        seen = cv2.warpPerspective(sand, view, (_SIDE, _SIDE), flags=cv2.INTER_LINEAR)
        cv2.randn(noise, mean, sigma)
        return cv2.add(seen, noise, dtype=cv2.CV_8U)

    cv2.setNumThreads(1)
    return least(draw, 1, steps=200)


def _tiny_renderer() -> Cost:
    client = pybullet.connect(pybullet.DIRECT)
    box = pybullet.createVisualShape(pybullet.GEOM_BOX, halfExtents=(0.21, 0.065, 0.065))
    ground = pybullet.createVisualShape(pybullet.GEOM_BOX, halfExtents=(5.0, 5.0, 0.1))
    pybullet.createMultiBody(0, -1, box, (0.0, 0.0, 0.065))
    pybullet.createMultiBody(0, -1, ground, (0.0, 0.0, -0.1))
    view = pybullet.computeViewMatrix((0.0, 0.0, _ALTITUDE_M), (0.0, 0.0, 0.0), (1.0, 0.0, 0.0))
    angle = 2.0 * math.degrees(math.atan(0.5 * _SIDE / _OPTICS.focal_px))
    lens = pybullet.computeProjectionMatrixFOV(angle, 1.0, 0.1, 10.0)
    try:
        return least(
            lambda: pybullet.getCameraImage(
                *(_SIDE, _SIDE, view, lens), renderer=pybullet.ER_TINY_RENDERER
            ),
            1,
            steps=20,
        )
    finally:
        pybullet.disconnect(client)
