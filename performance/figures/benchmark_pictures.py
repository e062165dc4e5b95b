"""Redraw the pictures of the benchmark pages: `./run performance benchmark_pictures [FOLDER]`.

Each is what the vehicle's camera sees at a level of the benchmark, a little off the station or over
an arm at work, with the true outline of the target; where a route is followed, its plan.
"""

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np

from performance.figures.route_plan import followed
from seamark import templates
from seamark.sim import registry
from seamark.sim.camera import start_pose
from seamark.sim.engine.replay import CameraFrame, Image, Replay
from seamark.sim.engine.trial import run_trial
from seamark.sim.recording.telemetry import Rows, answers_of, detections
from seamark.sim.settings.route import RouteSettings

FOLDER = Path(templates.__file__).parent / "static" / "benchmarks"
QUALITY = 84
SEED = 2026
AMBER = (0, 176, 255)  # blue, green, red
FRAME = 40  # of the trial, where nothing but the vehicle's place is shown
OFFSET = np.array([0.05, -0.04, 0.0, 0.02, 0.01, 0.15])  # [m, rad] from the station
DISTANCES_M = {"controller": 2.27, "tracker": 1.27}  # of the camera from the target
AT_WORK_S = {
    "recover-v1": 9.0,
    "valve-v1": 16.0,
    "connect-v1": 26.0,
    "mission-v1": 18.0,
    "dock-v1": 24.0,
}  # into a level of a benchmark in which something is worked on, or entered
# what works there, if not the scripted entry
AT_WORK: dict[str, str] = {"mission-v1": "chain", "dock-v1": "straight"}
CLEAR: dict[str, dict[str, object]] = {
    "mission-v1": {"loop1_values": [0.2]},
    "dock-v1": {"turbidity_1_m": 0.0},
}  # settings of the one level that is shown
LEVELS = {
    "currents-v3": 3,
    "currents-v2": 3,
    "visibility-v3": 12,
    "visibility-v2": 12,
    "visibility-v1": 8,
}  # not the first one's water


def picture(name: str) -> Image:
    """Return the picture of a benchmark, (H, W, 3)."""
    if registry.benchmark(name).role == "detector":
        return recognised(name)
    if isinstance(registry.benchmark(name).read({}), RouteSettings):
        return followed(name, SEED)
    frame = at_work(name, AT_WORK_S[name]) if name in AT_WORK_S else off_station(name)
    image = frame.colour()
    corners = np.round(16.0 * frame.corners()).astype(np.int32)
    cv2.polylines(image, [corners.reshape(4, 2)], True, AMBER, 1, cv2.LINE_AA, 4)
    return image


def recognised(name: str) -> Image:
    """Return the image of a bottom in clear water in which most objects count, outlined."""
    config = registry.benchmark(name).read({})
    levels: list[Rows] = []
    oracle = registry.benchmark(name).load().built_in("oracle", config)
    run_trial(name, config, oracle, seed=SEED, trial=0, on_rows=levels.append)
    rows = levels[0]
    answers = answers_of(detections(rows))
    given = answers[:, :, 0] >= 0.0
    best = int(given.sum(axis=1).argmax())
    image = Replay(name, config, lambda _trial: SEED).frame(rows[best]).colour()
    for answer in answers[best][given[best]]:
        corners = np.round(16.0 * answer[2:10]).astype(np.int32)
        cv2.polylines(image, [corners.reshape(4, 2)], True, AMBER, 1, cv2.LINE_AA, 4)
    return image


def off_station(name: str) -> CameraFrame:
    """Return what the camera sees a little off the station."""
    benchmark = registry.benchmark(name)
    height_m, level = DISTANCES_M[benchmark.role], LEVELS.get(name, 0)
    camera = Replay(name, benchmark.read({}), lambda _trial: SEED).camera(0, level)
    motion = np.zeros(12)
    motion[:6] = start_pose(camera.optics, camera.target, height_m) + OFFSET
    return CameraFrame(camera, camera.at(motion, FRAME), FRAME)


def at_work(name: str, time_s: float) -> CameraFrame:
    """Return what the camera sees as a built-in entry works with the arm."""
    benchmark = registry.benchmark(name)
    only: dict[str, object] = {"levels": [0.1], "level_duration_s": time_s}
    config = benchmark.read(only | CLEAR.get(name, {}))
    rows: list[Rows] = []
    solution = benchmark.load().built_in(AT_WORK.get(name, "scripted"), config)
    run_trial(name, config, solution, seed=SEED, trial=0, on_rows=rows.append)
    return Replay(name, config, lambda _trial: SEED).frame(rows[-1][-1])


def main(arguments: Sequence[str]) -> int:
    """Write the pictures."""
    folder = Path(*arguments) if arguments else FOLDER
    folder.mkdir(exist_ok=True)
    for name in registry.BENCHMARKS:
        path = folder / f"{name}.jpg"
        cv2.imwrite(str(path), picture(name), [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
    return 0
