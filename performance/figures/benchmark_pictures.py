"""Redraw the pictures of the benchmark pages: `./run performance benchmark_pictures [FOLDER]`.

Each is what the vehicle's camera sees at a level of the benchmark, a little off the station, with
the true outline of the target.
"""

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np

from seamark import templates
from seamark.sim import registry
from seamark.sim.camera import start_pose
from seamark.sim.engine.replay import Replay

FOLDER = Path(templates.__file__).parent / "static" / "benchmarks"
QUALITY = 84
SEED = 2026
AMBER = (0, 176, 255)  # blue, green, red
OFFSET = np.array([0.05, -0.04, 0.0, 0.02, 0.01, 0.15])  # [m, rad] from the station
DISTANCES_M = {"controller": 2.27, "tracker": 1.27}  # of the camera from the target
LEVELS = {"currents-v2": 3, "visibility-v2": 12, "visibility-v1": 8}  # not the first one's water


def picture(name: str) -> "np.ndarray[tuple[int, ...], np.dtype[np.uint8]]":
    """Return the picture of a benchmark, (H, W, 3)."""
    benchmark = registry.benchmark(name)
    height_m, level = DISTANCES_M[benchmark.role], LEVELS.get(name, 0)
    camera = Replay(name, benchmark.read({}), lambda _trial: SEED).camera(0, level)
    motion = np.zeros(12)
    motion[:6] = start_pose(camera.optics, camera.target, height_m) + OFFSET
    image = camera.colour(motion, 40)
    corners = np.round(16.0 * camera.corners(motion)).astype(np.int32)
    cv2.polylines(image, [corners.reshape(4, 2)], True, AMBER, 1, cv2.LINE_AA, 4)
    return image


def main(arguments: Sequence[str]) -> int:
    """Write the pictures."""
    folder = Path(*arguments) if arguments else FOLDER
    folder.mkdir(exist_ok=True)
    for name in registry.BENCHMARKS:
        path = folder / f"{name}.jpg"
        cv2.imwrite(str(path), picture(name), [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
    return 0
