"""Pictures of the vehicle's camera, made again from the telemetry: no video is ever stored.

The only part of the server that loads the simulator's camera (OpenCV, compiled code), and only when
the first picture is asked for or the background thread of `warm_up` is done.
"""

import json
import threading
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
import structlog
from numpy.typing import NDArray

from seamark.server.runs.files import RunFiles
from seamark.server.runs.seeds import TrialSeeds, trial_seeds
from seamark.server.runs.views import RunView
from seamark.server.settings import Settings
from seamark.sim import registry
from seamark.sim.recording.telemetry import INDEX, WIDTH

if TYPE_CHECKING:
    from seamark.sim.engine.replay import Replay

JPEG_QUALITY = 88
GREEN, AMBER, WHITE = (75, 230, 70), (0, 176, 255), (235, 240, 240)  # blue, green, red
_CROSS_PX = 9  # half of the centre cross
_SUBPIXEL_BITS = 4  # OpenCV draws at sixteenths of a pixel
_CORNERS = slice(INDEX["corner_0"], INDEX["corner_7"] + 1)
# A camera has one work area, so one picture is drawn at a time; a picture takes milliseconds.
_lock = threading.Lock()
_log = structlog.get_logger()
Picture = NDArray[np.uint8]
Row = NDArray[np.float64]


def picture(settings: Settings, run: RunView, *, trial: int, t: float) -> bytes | None:
    """Return the JPEG of the view nearest to simulated time `t`, or None without telemetry.

    The tracker's box is drawn green, the true outline thin and amber, the centre as a cross.
    """
    row = _row_at(RunFiles(settings.data, run.id), trial, t)
    if row is None:
        return None
    config = json.dumps(run.config, sort_keys=True)
    with _lock:
        frame = _replay(run.benchmark, config, trial_seeds(run, settings)).frame(row)
        image, truth = frame.colour(), frame.corners()
    return _jpeg(_marked(image, row, truth))


def warm_up() -> threading.Thread:
    """Load and compile in the background, so that the first visitor does not wait for it."""
    thread = threading.Thread(target=_warm_up, name="warm-camera", daemon=True)
    thread.start()
    return thread


def _warm_up() -> None:
    """Draw one picture of each benchmark, so that all that the first visitor's needs is loaded."""
    from seamark.sim.engine.replay import Replay  # noqa: PLC0415 - as above

    row = np.zeros(WIDTH)
    for name in registry.BENCHMARKS:
        with _lock:
            frame = Replay(name, registry.benchmark(name).read({}), lambda _trial: 0).frame(row)
            _jpeg(_marked(frame.colour(), row, frame.corners()))
    _log.info("camera_warm")


@lru_cache(maxsize=4)
def _replay(benchmark: str, config: str, seeds: TrialSeeds) -> "Replay":
    """Return the pictures of a configuration; a run's page asks for many of them."""
    from seamark.sim.engine.replay import Replay  # noqa: PLC0415 - as above

    return Replay(benchmark, registry.benchmark(benchmark).restore(json.loads(config)), seeds)


def _row_at(files: RunFiles, trial: int, t: float) -> Row | None:
    """Return the last row of a trial that is not later than `t`; else its first."""
    after = files.rows_until(trial, t + 1e-6)
    for at in (after - 1, after):  # before the first row of a trial: that one
        found = files.rows(at, at + 1) if at >= 0 else np.empty((0, 0))
        if len(found) and int(found[0, INDEX["trial"]]) == trial:
            row: Row = found[0]
            return row
    return None


def _marked(image: Picture, row: Row, truth: Row) -> Picture:
    """Draw the centre, where the tracker believes the target is and, thin on top, the truth."""
    import cv2  # noqa: PLC0415 - as above

    height, width = image.shape[:2]
    middle = (width // 2, height // 2)
    cv2.drawMarker(image, middle, WHITE, cv2.MARKER_CROSS, 2 * _CROSS_PX, 1, cv2.LINE_AA)
    if row[INDEX["tracker_ok"]] == 1.0:
        _outline(image, row[_CORNERS].reshape(4, 2), GREEN, 3)
    _outline(image, truth, AMBER, 1)
    return image


def _outline(image: Picture, corners: Row, colour: tuple[int, int, int], thickness: int) -> None:
    import cv2  # noqa: PLC0415 - as above

    # A lost target can be anywhere; OpenCV's integers cannot.
    if not np.isfinite(corners).all() or np.abs(corners).max() > 1e5:
        return
    points = np.round(corners * (1 << _SUBPIXEL_BITS)).astype(np.int32)
    cv2.polylines(image, [points], True, colour, thickness, cv2.LINE_AA, _SUBPIXEL_BITS)


def _jpeg(image: Picture) -> bytes:
    import cv2  # noqa: PLC0415 - as above

    done, encoded = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
    if not done:
        raise RuntimeError("OpenCV could not encode a picture")
    data: bytes = encoded.tobytes()
    return data
