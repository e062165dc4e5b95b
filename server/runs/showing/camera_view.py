"""Images of the vehicle's camera, re-rendered from the telemetry: no video is stored.

The only part of the server that loads the simulator's camera (OpenCV, compiled code), lazily: with
the first image or in `warm_up`.
"""

import json
import os
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any

import numpy as np
import structlog
from numpy.typing import NDArray

from seamark.formats.jpeg import jpeg
from seamark.server.programs import own_files
from seamark.server.runs.data import stored_files
from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.record.seeds import TrialSeeds, trial_seeds
from seamark.server.runs.showing.detections import answered, missed
from seamark.server.runs.showing.views import RunView
from seamark.server.settings import Settings
from seamark.sim import registry
from seamark.sim.control.observation import PIPE
from seamark.sim.numerics.numba_internals import numba_folder
from seamark.sim.numerics.shared_parts import run_parts
from seamark.sim.recording.telemetry import (
    INDEX,
    SEARCH_INDEX,
    has_detections,
    has_route,
    has_search,
)
from seamark.sim.settings.search import LONGEST_PERIOD_S, TARGET_LABEL

if TYPE_CHECKING:
    from seamark.sim.camera.camera import Camera
    from seamark.sim.engine.replay import Replay

IMAGES_KEPT = 64  # of 60 KB
GREEN, AMBER, WHITE = (75, 230, 70), (0, 176, 255), (235, 240, 240)  # blue, green, red
RED, GREY, BLACK = (70, 70, 255), (190, 190, 190), (20, 20, 20)
PINK = (230, 120, 255)
_OF_OUTCOME = {"hit": GREEN, "false alarm": RED, "ignored": GREY}
_ENLARGED = 2  # times, of images of 320 x 240: labels stay legible
_TEXT_SCALE, _TEXT_MARGIN_PX = 0.4, 3
_ANSWER_TEXT_SCALE = 0.7 / 640.0  # of a single answer, for each pixel of the image's width
_CROSS_PX = 9  # half of the centre cross
_SUBPIXEL_BITS = 4  # OpenCV draws at sixteenths of a pixel
_CORNERS = slice(INDEX["corner_0"], INDEX["corner_7"] + 1)
_ANSWER = slice(SEARCH_INDEX["found_x0"], SEARCH_INDEX["found_confidence"] + 1)
# A camera has one set of buffers, so images are rendered one at a time; each takes milliseconds.
_lock = threading.Lock()
_warm = threading.Event()
_log = structlog.get_logger()
Image = NDArray[np.uint8]
Row = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Drawn:
    """What is drawn onto an image; with nothing it is the bare image."""

    # The outline that the tracker reported, green; the answers of a detector, where one looks for
    # what the tracker then follows its last one, pink.
    tracked: bool = True
    truth: bool = True  # the true outline, thin and amber; of a detector, those it missed
    on_arm: bool = False  # the image of the camera on the arm instead, in which nothing is drawn
    sonar: bool = False  # the fan of the imaging sonar instead, likewise


DRAWN = Drawn()
ON_ARM = Drawn(tracked=False, truth=False, on_arm=True)
SONAR = Drawn(tracked=False, truth=False, sonar=True)


def render(
    settings: Settings,
    run: RunView,
    *,
    trial: int,
    t: float,
    drawn: Drawn = DRAWN,
    files: RunFiles | None = None,
) -> bytes | None:
    """Return the JPEG of the last image before simulated time `t` [s]; None without telemetry.

    The image centre is a cross, if anything is drawn.

    Parameters
    ----------
    files
        Those of a run that is not stored with the others.

    Raises
    ------
    NoCameraOnArm
        There is no camera on an arm.
    NoSonar
        There is no imaging sonar.
    """
    row = _row_at(stored_files.of_run(settings, run) if files is None else files, trial, t)
    if row is None:
        return None
    config = json.dumps(run.config, sort_keys=True)
    # Of many viewers who ask for the same image, all but the first find it.
    with _lock, own_files.lent_to(settings, run):
        seeds = trial_seeds(run, settings)
        return _rendered(run.benchmark, config, seeds, row.tobytes(), drawn)


def render_row(benchmark: str, config: Mapping[str, Any], seed: int, row: Row) -> bytes:
    """Return the JPEG of one row of a benchmark that needs no vehicle, with all that is drawn."""
    seeds = TrialSeeds(benchmark=benchmark, seed=seed, submission="", secret=b"")
    with _lock:
        text = json.dumps(config, sort_keys=True)
        return _rendered(benchmark, text, seeds, row.tobytes(), DRAWN)


@lru_cache(maxsize=IMAGES_KEPT)
def _rendered(
    benchmark: str, config: str, seeds: TrialSeeds, row_bytes: bytes, drawn: Drawn
) -> bytes:
    """Return the JPEG of a row; all viewers of a live run ask for the same images."""
    row: Row = np.frombuffer(row_bytes)
    frame = _replay(benchmark, config, seeds).frame(row)
    if drawn.on_arm:
        return jpeg(frame.on_arm())
    if drawn.sonar:
        return jpeg(frame.fan())
    image, truth = frame.colour(), frame.corners()
    return jpeg(annotated(image, row, truth, drawn))


@contextmanager
def camera_of(settings: Settings, run: RunView, *, trial: int, level: int) -> "Iterator[Camera]":
    """Give the camera of a level of a run, which nobody else uses meanwhile."""
    config = json.dumps(run.config, sort_keys=True)
    with _lock, own_files.lent_to(settings, run):
        yield _replay(run.benchmark, config, trial_seeds(run, settings)).camera(trial, level)


def warm_up() -> None:
    """Render one image of each benchmark, so that everything is loaded and compiled.

    What a worker on this machine is compiling is left until it is done.
    """
    parts = {name: partial(_render_one, name) for name in registry.BENCHMARKS}
    parts |= {PIPE: partial(_render_one, "track-v1", route=PIPE)}
    run_parts(parts, numba_folder(os.environ))
    _warm.set()
    _log.info("camera_warm")


def _render_one(benchmark: str, **settings: str) -> None:
    from seamark.sim.engine.replay import Replay  # noqa: PLC0415 - loads OpenCV

    config = registry.benchmark(benchmark).read(settings)
    row = np.zeros(config.telemetry_shape()[1])
    with _lock:
        frame = Replay(benchmark, config, lambda _trial: 0).frame(row)
        jpeg(annotated(frame.colour(), row, frame.corners(), DRAWN))


def is_warm() -> bool:
    """Return whether `warm_up` has ended in this process: an image takes milliseconds now."""
    return _warm.is_set()


@lru_cache(maxsize=4)
def _replay(benchmark: str, config: str, seeds: TrialSeeds) -> "Replay":
    """Return the renderer of a run; the page of a run requests many images of it."""
    from seamark.sim.engine.replay import Replay  # noqa: PLC0415 - loads OpenCV

    return Replay(benchmark, registry.benchmark(benchmark).restore(json.loads(config)), seeds)


def _row_at(files: RunFiles, trial: int, t: float) -> Row | None:
    """Return the last row of a trial up to time `t`, else its first; None without rows.

    Where a detector looks for the target, it has the last answer.
    """
    after = files.rows_until(trial, t + 1e-6)
    for at in (after - 1, after):  # before its first row: the first row
        rows = files.rows(at, at + 1) if at >= 0 else np.empty((0, 0))
        if len(rows) and int(rows[0, INDEX["trial"]]) == trial:
            row: Row = rows[0]
            return _with_last_answer(files, row, at) if has_search(len(row)) else row
    return None


def _with_last_answer(files: RunFiles, row: Row, at: int) -> Row:
    """Return the row at a place with the answer to the image that the detector was given last."""
    trial, since = int(row[INDEX["trial"]]), row[INDEX["t"]] - LONGEST_PERIOD_S
    rows = files.rows(files.rows_until(trial, since), at + 1)
    here = rows[:, INDEX["level"]] == row[INDEX["level"]]
    looked = np.flatnonzero(here & (rows[:, SEARCH_INDEX["looked"]] == 1.0))
    if not looked.size:
        return row
    answered = row.copy()
    answered[_ANSWER] = rows[looked[-1], _ANSWER]
    return answered


def annotated(image: Image, row: Row, truth: Row, drawn: Drawn) -> Image:
    """Draw the image centre, the tracked outline and, thin on top, the true outline.

    Of a row with detections, draw these instead; of one of a search, also the answer. Where a route
    is followed, nobody looks at a target, but perhaps at a pipe, of which the outline is drawn.
    """
    if not (drawn.tracked or drawn.truth):
        return image
    if has_route(len(row)):
        return _with_pipe(image, row, drawn)
    if has_detections(len(row)):
        return _with_detections(image, row, drawn)
    import cv2  # noqa: PLC0415 - loads OpenCV

    height, width = image.shape[:2]
    middle = (width // 2, height // 2)
    cv2.drawMarker(image, middle, WHITE, cv2.MARKER_CROSS, 2 * _CROSS_PX, 1, cv2.LINE_AA)
    answers = drawn.tracked and has_search(len(row))
    if answers:
        _outline(image, _answer_corners(row), PINK, 5)
    if drawn.tracked and row[INDEX["tracker_ok"]] == 1.0:
        _outline(image, row[_CORNERS].reshape(4, 2), GREEN, 3)
    if drawn.truth:
        _outline(image, truth, AMBER, 1)
    if answers:
        _label_answer(image, row)
    return image


def _with_pipe(image: Image, row: Row, drawn: Drawn) -> Image:
    """Return an image with the piece of a pipe that the detector last saw."""
    if drawn.tracked and row[INDEX["tracker_ok"]] == 1.0:
        _outline(image, row[_CORNERS].reshape(4, 2), GREEN, 2)
    return image


def _answer_corners(row: Row) -> Row:
    """Return the corners (4, 2) [px] of the answer in a row of a search; NaN without one."""
    corners: Row = row[_ANSWER][:-1].reshape(4, 2)
    return corners


def _label_answer(image: Image, row: Row) -> None:
    corners, confidence = _answer_corners(row), row[SEARCH_INDEX["found_confidence"]]
    if np.isfinite(corners).all():
        scale = _ANSWER_TEXT_SCALE * image.shape[1]
        _label(image, f"{TARGET_LABEL} {confidence:.2f}", corners, PINK, scale=scale)


def _with_detections(image: Image, row: Row, drawn: Drawn) -> Image:
    """Return an enlarged image with a detector's answers and, thin, the objects that it missed."""
    import cv2  # noqa: PLC0415 - loads OpenCV

    height, width = (_ENLARGED * size for size in image.shape[:2])
    enlarged = cv2.resize(image, (width, height)).astype(np.uint8, copy=False)
    if drawn.truth:
        for one in missed(row):
            _outline(enlarged, _enlarged(one.corners), AMBER, 2)
    if drawn.tracked:
        answers = list(answered(row))
        for answer in reversed(answers):  # the most confident ones on top
            _outline(enlarged, _enlarged(answer.corners), _OF_OUTCOME[answer.outcome], 3)
        for answer in reversed(answers):
            text = f"{answer.label} {answer.confidence:.2f}"
            _label(enlarged, text, _enlarged(answer.corners), _OF_OUTCOME[answer.outcome])
    return enlarged


def _enlarged(corners: Row) -> Row:
    """Return corners in the enlarged image; the centre of a pixel is at whole coordinates."""
    return _ENLARGED * (corners + 0.5) - 0.5


def _label(
    image: Image,
    text: str,
    corners: Row,
    colour: tuple[int, int, int],
    *,
    scale: float = _TEXT_SCALE,
) -> None:
    """Write a text on a bar of a colour above the corners, or as near as it is in the image."""
    import cv2  # noqa: PLC0415 - loads OpenCV

    font, margin = cv2.FONT_HERSHEY_SIMPLEX, _TEXT_MARGIN_PX
    (width, height), below = cv2.getTextSize(text, font, scale, 1)
    width, height = width + 2 * margin, height + below + margin
    left, top = corners.min(axis=0).tolist()
    x = round(min(max(left, 0), image.shape[1] - width))
    y = round(min(max(top - height, 0), image.shape[0] - height))
    cv2.rectangle(image, (x, y), (x + width, y + height), colour, cv2.FILLED)
    at = (x + margin, y + height - below)
    cv2.putText(image, text, at, font, scale, BLACK, 1, cv2.LINE_AA)


def _outline(image: Image, corners: Row, colour: tuple[int, int, int], thickness: int) -> None:
    import cv2  # noqa: PLC0415 - loads OpenCV

    # A diverged tracker may report any coordinates; those of OpenCV are 32-bit integers.
    if not np.isfinite(corners).all() or np.abs(corners).max() > 1e5:
        return
    points = np.round(corners * (1 << _SUBPIXEL_BITS)).astype(np.int32)
    cv2.polylines(image, [points], True, colour, thickness, cv2.LINE_AA, _SUBPIXEL_BITS)
