"""Real programs with the libraries that a box has: OpenCV, SciPy, ONNX Runtime."""

import os
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest
import scipy.linalg

from seamark.programs.archives import normal_form
from seamark.sandbox.box import Box
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import ProgramEnded, Verdict
from tests.sandbox.languages.python.networks import heat_map, kernels, policy, weights

pytestmark = pytest.mark.host

LAYOUT = {
    "observation": [["t", 0], ["error", 3]],
    "command": ["surge", "sway", "heave", "yaw_rate"],
}
VALUES = [0.0, 0.5, -0.25, 0.125]
MATCHER = """
import cv2
import numpy as np

class Tracker:
    def __init__(self, config):
        pass

    def start(self, image, corners):
        left, top = corners.min(axis=0).astype(int)
        right, bottom = corners.max(axis=0).astype(int)
        self.template = image[top:bottom, left:right].copy()
        self.corners = corners - [left, top]

    def update(self, image):
        found = cv2.matchTemplate(image, self.template, cv2.TM_CCOEFF_NORMED)
        _, score, _, (x, y) = cv2.minMaxLoc(found)
        return self.corners + [x, y] if score > 0.5 else None
"""
FLOW = """
import cv2
import numpy as np

class Tracker:
    def __init__(self, config):
        pass

    def start(self, image, corners):
        self.before, self.corners = image, corners
        mask = np.zeros_like(image)
        cv2.fillConvexPoly(mask, corners.astype(np.int32), 255)
        self.points = cv2.goodFeaturesToTrack(image, 50, 0.01, 3, mask=mask)

    def update(self, image):
        after, found, _ = cv2.calcOpticalFlowPyrLK(self.before, image, self.points, None)
        moved = np.median((after - self.points)[found.ravel() == 1], axis=0).ravel()
        self.before, self.points, self.corners = image, after, self.corners + moved
        return self.corners
"""
LQR = """
import numpy as np
from scipy.linalg import solve_discrete_are
from scipy.signal import butter, lfilter_zi

class Controller:
    def __init__(self, config):
        a, b = np.array([[1.0, 0.05], [0.0, 0.9]]), np.array([[0.0], [0.05]])
        p = solve_discrete_are(a, b, np.eye(2), np.eye(1))
        self.gain = np.linalg.solve(np.eye(1) + b.T @ p @ b, b.T @ p @ a)[0]
        self.state = lfilter_zi(*butter(2, 0.2))

    def step(self, observation):
        surge, sway = (self.gain[0] * observation.error[axis] for axis in (0, 1))
        return [surge, sway, 0.0, 0.0]
"""
POLICY = """
import numpy as np
import onnxruntime

class Controller:
    def __init__(self, config):
        self.session = onnxruntime.InferenceSession("policy.onnx")

    def step(self, observation):
        x = np.asarray(observation.error, np.float32)[None]
        return self.session.run(None, {"x": x})[0][0]
"""


SEEING = """
import numpy as np
import onnxruntime

class Detector:
    def __init__(self, config):
        self.session = onnxruntime.InferenceSession("heat_map.onnx")

    def detect(self, image):
        x = (image / np.float32(255))[None, None]
        (maps,) = self.session.run(None, {"x": x})[0]
        found = []
        for number, one in enumerate(maps):
            row, column = np.unravel_index(one.argmax(), one.shape)
            left, top = 16.0 * column, 16.0 * row
            corners = [[left, top], [left + 15, top], [left + 15, top + 15], [left, top + 15]]
            found.append((f"class {number}", corners, min(float(one.max()), 1.0)))
        return found
"""


@pytest.fixture
def box(isolation: IsolationLevel) -> Iterator[Box]:
    core = min(os.sched_getaffinity(0))  # as for a run
    with Box(limits=Limits(), isolation=isolation, core=core) as started:
        yield started


def scene(shift: tuple[int, int] = (0, 0)) -> np.ndarray:
    """Return a grey image of smooth noise, moved by whole pixels."""
    coarse = np.random.default_rng(3).integers(0, 256, (24, 32))
    fine = np.kron(coarse, np.ones((10, 10)))
    smooth = (fine + np.roll(fine, 5, 0) + np.roll(fine, 5, 1) + np.roll(fine, (5, 5), (0, 1))) / 4
    return np.ascontiguousarray(np.roll(smooth, shift[::-1], (0, 1)).astype(np.uint8))


CORNERS = np.array([[100.0, 80.0], [160.0, 80.0], [160.0, 120.0], [100.0, 120.0]])


@pytest.mark.parametrize("source", [MATCHER, FLOW], ids=["template matching", "optical flow"])
def test_a_tracker_follows_its_target_with_opencv(box: Box, source: str) -> None:
    box.load(source.encode(), "mine.py", {}, {"role": "tracker"})
    box.start(scene(), CORNERS)

    answers = [box.update(scene((step, -step))) for step in (1, 2, 3)]

    moved = [CORNERS + np.array([step, -step]) for step in (1, 2, 3)]
    assert np.allclose(np.array(answers), moved, atol=0.3)
    assert box.finish().verdict is Verdict.OK


def test_a_controller_solves_a_riccati_equation_with_scipy(box: Box) -> None:
    a, b = np.array([[1.0, 0.05], [0.0, 0.9]]), np.array([[0.0], [0.05]])
    p = scipy.linalg.solve_discrete_are(a, b, np.eye(2), np.eye(1))
    gain = np.linalg.solve(np.eye(1) + b.T @ p @ b, b.T @ p @ a)[0, 0]

    box.load(LQR.encode(), "mine.py", {}, LAYOUT)

    assert box.step(VALUES) == pytest.approx([gain * 0.5, gain * -0.25, 0.0, 0.0])


def test_a_learned_policy_runs_with_onnx_runtime(box: Box) -> None:
    files = {"main.py": POLICY.encode(), "policy.onnx": policy()}
    first, second = weights()

    box.load(normal_form(files, limits=Limits()), "mine.zip", {}, LAYOUT)
    answer = box.step(VALUES)
    outcome = box.finish()

    assert answer == pytest.approx(np.tanh(np.float32(VALUES[1:]) @ first) @ second, abs=1e-5)
    assert outcome.output == b""  # the library's complaints about the box are not in the log
    assert outcome.verdict is Verdict.OK


def test_a_learned_detector_runs_with_onnx_runtime_in_one_thread(box: Box) -> None:
    files = {"detector.py": SEEING.encode(), "heat_map.onnx": heat_map()}
    image = scene()

    box.load(normal_form(files, limits=Limits()), "mine.zip", {}, {"role": "detector"})
    found, again = box.detect(image), box.detect(image)

    assert found == again
    assert [one.label for one in found] == [f"class {number}" for number in range(8)]
    wanted = [hottest(one) for one in heat(image)]
    assert [one.corners[0] for one in found] == wanted
    assert [len(os.listdir(f"/proc/{pid}/task")) for pid in box.processes()] == [1, 1]
    assert box.usage().memory_mib < Limits().memory_mib / 4
    assert box.finish().output == b""


def heat(image: np.ndarray) -> np.ndarray:
    """Return the maps of the network, computed by OpenCV."""
    maps = [image.astype(np.float64) / 255.0]
    for layer in kernels():
        maps = [
            np.maximum(sum(map(strided, maps, kernel)), 0.0)  # type: ignore[arg-type]
            for kernel in layer
        ]
    return np.array(maps)


def strided(channel: np.ndarray, kernel: np.ndarray) -> np.ndarray:
    border = cv2.BORDER_CONSTANT
    return cv2.filter2D(channel, -1, kernel.astype(np.float64), borderType=border)[::2, ::2]


def hottest(one: np.ndarray) -> tuple[float, float]:
    row, column = np.unravel_index(one.argmax(), one.shape)
    return 16.0 * column, 16.0 * row


def test_libraries_start_no_threads_of_their_own(box: Box) -> None:
    using = """
import cv2
import numpy as np

cv2.GaussianBlur(np.zeros((2000, 2000), np.uint8), (9, 9), 2)
np.ones((500, 500)) @ np.ones((500, 500))
print(cv2.getNumThreads())
"""
    files = {"main.py": using.encode() + POLICY.encode(), "policy.onnx": policy()}

    box.load(normal_form(files, limits=Limits()), "mine.zip", {}, LAYOUT)
    box.step(VALUES)

    assert box.take_output() == b"1\n"
    assert [len(os.listdir(f"/proc/{pid}/task")) for pid in box.processes()] == [1, 1]


def test_the_packages_of_a_box_are_only_those_for_programs(box: Box) -> None:
    listing = "import os\nprint(*sorted(os.listdir('/box/packages')))\n" + LQR

    box.load(listing.encode(), "mine.py", {}, LAYOUT)

    expected = {"numpy", "scipy", "cv2", "onnxruntime", "seamark_inside"}
    found = {name for name in box.take_output().decode().split() if not name.endswith(".libs")}
    assert found == expected
    assert not Path("/box").exists()  # a folder of the box, not of the host


def test_the_error_about_a_missing_module_names_the_packages_that_are_there(box: Box) -> None:
    with pytest.raises(ProgramEnded) as end:
        box.load(b"import torch.nn\n", "mine.py", {}, LAYOUT)

    assert end.value.outcome.sentence == (
        "ModuleNotFoundError: No module named 'torch'; beside the standard library, the box has "
        "cv2, numpy, onnxruntime, scipy (line 1 of mine.py)"
    )
