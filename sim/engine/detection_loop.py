"""One level of pattern recognition: a prescribed path, and a detector that is shown each image."""

import time
from collections.abc import Sequence
from enum import Enum
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from seamark.sim.camera.bottom.camera import BottomCamera, Seen
from seamark.sim.camera.bottom.things import OBJECTS
from seamark.sim.detectors import Detection, Detector
from seamark.sim.engine.open_loop import Path, Row, Timing
from seamark.sim.metrics.detection import COUNTS, Object, match
from seamark.sim.recording.telemetry import (
    DELIVERED_ROWS,
    INDEX,
    OBJECT,
    STEP_US,
    OnRows,
    Recorder,
    detections,
    objects_of,
    width_for,
)

_TIME = slice(INDEX["trial"], INDEX["t"] + 1)
_MOTION = slice(INDEX["x"], INDEX["r"] + 1)


class Oracle(Enum):
    """Stands for the true corners, which only a level knows."""

    TRUTH = "oracle"


class DetectionTiming(Timing, Protocol):
    """The settings that a level needs."""

    @property
    def colour(self) -> bool:
        """Whether the detector gets colour images."""


class DetectionLoop:
    """Runs one level image by image; telemetry of parts that are not simulated stays 0."""

    def __init__(
        self,
        config: DetectionTiming,
        path: Path,
        camera: BottomCamera,
        detector: Detector | Oracle,
        *,
        trial: int,
        level: int,
    ) -> None:
        """Set up a level."""
        self._path, self._camera = path, camera
        self._detector = None if isinstance(detector, Oracle) else detector
        self._show = self._colour if config.colour else camera.grey
        self._trial, self._level = trial, level
        self._steps, self._dt = config.control_steps_per_level, config.control_period_s
        self._start_s = level * config.level_duration_s
        self._first_frame = level * self._steps
        self._size = camera.optics.width, camera.optics.height

    def run(self, on_rows: OnRows) -> None:
        """Run the level; rows go to `on_rows`, the last ones even if the detector raises."""
        together = min(max(round(1.0 / self._dt), 1), DELIVERED_ROWS)  # once a simulated second
        recorder = Recorder(on_rows, width=width_for(0, detections=True), together=together)
        try:
            for step in range(self._steps):
                self._step(step, recorder.next_row())
                recorder.commit()
        finally:
            recorder.flush()

    def close(self) -> None:
        """Do nothing: this loop holds no resources."""

    def _colour(self, motion: Row, frame: int) -> NDArray[np.uint8]:
        """Return the image (H, W, 3) as programs get it: red, green, blue (docs/protocol.md)."""
        return np.ascontiguousarray(self._camera.colour(motion, frame)[:, :, ::-1])

    def _step(self, step: int, row: Row) -> None:
        """Show the detector an image, and fill the row."""
        motion = np.concatenate(self._path.pose_and_velocity(step * self._dt))
        seen = self._camera.seen(motion)
        image = self._show(motion, self._first_frame + step)
        image.flags.writeable = False
        objects = [
            Object(one.corners, one.uncovered, one.distance, one.angle) for one in seen[:OBJECTS]
        ]
        decoys = [one.corners for one in seen[OBJECTS:]]
        before = time.perf_counter_ns()
        answers = (
            _true(seen, match(objects, decoys, (), self._size).columns)
            if self._detector is None
            else self._detector.detect(image)
        )
        row[STEP_US] = (time.perf_counter_ns() - before) * 1e-3
        row[_TIME] = self._trial, self._level, self._start_s + step * self._dt
        row[_MOTION] = motion
        detections(row)[:] = match(objects, decoys, answers, self._size).columns


def _true(seen: Sequence[Seen], columns: Row) -> list[Detection]:
    """Return the oracle's answers: every object that counts in an image."""
    counting = objects_of(columns)[:, OBJECT["state"]] == COUNTS
    return [
        Detection(one.name, one.corners, 1.0)
        for one, counts in zip(seen, counting.tolist(), strict=False)
        if counts
    ]
