"""The search in the loop: a detector looks for the target, and hands it over to the tracker."""

from collections import deque

import numpy as np
from numpy.typing import NDArray

from seamark.sim.camera.camera import Camera
from seamark.sim.detectors import Detection, Detector, make
from seamark.sim.engine.tracker_in_loop import Pose, TrackerInLoop
from seamark.sim.numerics.arrays import Array
from seamark.sim.recording.telemetry import SEARCH_INDEX
from seamark.sim.settings.search import TARGET_LABEL, FindingSettings
from seamark.sim.trackers import Tracker
from seamark.sim.trackers.template.warps import is_convex

PATIENCE_S = 1.0  # E: for which a tracker may be without the target before it is looked for again
_BETTER = 0.1  # E: of the confidence of an answer elsewhere, for the tracker to leave what it has
_FOUND = slice(SEARCH_INDEX["searching"], SEARCH_INDEX["found_confidence"] + 1)
_ANSWER = 3  # numbers of these columns before those of the answer


class SearchInLoop(TrackerInLoop):
    """A tracker over one level that has nothing to follow until a detector finds it.

    The detector gets a whole image in each period, whether the tracker has something or not. The
    tracker starts from the most confident answer, if that is confident enough. While it follows
    something, the answer there says how confident the detector is of it by now; it starts again
    from an answer elsewhere that is clearly more confident.
    """

    def __init__(
        self,
        camera: Camera,
        settings: FindingSettings,
        *,
        tracker: Tracker | None = None,
        detector: Detector | None = None,
    ) -> None:
        """Set up the given tracker and detector, or else the configured ones."""
        super().__init__(camera, settings, np.zeros((4, 2)), tracker=tracker)
        self._detector = detector or make(settings.detector, **settings.detector_options())
        self._period = max(1, round(settings.detector_period_s / settings.control_period_s))
        self._patience = round(PATIENCE_S / settings.control_period_s)
        self._least = settings.least_confidence
        self._steps = self._lost = 0
        self.searching = True
        self.looked = False  # whether the detector was given the present image
        self.best: Detection | None = None  # of its answers to that image
        self.confidence = 0.0  # that what the tracker has is the target

    def start(self, pose: Pose, frame: int) -> None:
        """Look for the target in the first image."""
        self._camera.follow(pose)
        self._look(pose, frame)

    def update(self, pose: Pose, frame: int) -> None:
        """Give the tracker the next image, if it has started, and the detector if it is time."""
        self._steps += 1
        self.looked, self.best = False, None
        if self.searching:
            self._camera.follow(pose)
        else:
            super().update(pose, frame)
            self._lost = 0 if self.ok else self._lost + 1
            if self._lost > self._patience:
                self.searching, self.confidence = True, 0.0
        if self._steps % self._period == 0:
            self._look(pose, frame)

    def _look(self, pose: Pose, frame: int) -> None:
        image = self._camera.grey(pose, frame)
        answers = [answer for answer in self._detector.detect(image) if _is_sound(answer)]
        self.looked = True
        self.best = max(answers, key=lambda answer: answer.confidence, default=None)
        here = [] if not self.ok else [one for one in answers if self._is_here(one)]
        if here:
            self.confidence = max(one.confidence for one in here)
        least = self.confidence + _BETTER if self.ok else self._least
        best = self.best
        if best is not None and best.confidence >= least and all(best is not one for one in here):
            self._hand_over(best, image, pose)

    def _is_here(self, answer: Detection) -> bool:
        """Return whether an answer is on what the tracker has: its middle within half a side."""
        mine, other = self._corners.mean(axis=0), answer.corners.mean(axis=0)
        side = self._corners[1] - self._corners[0]
        off = other - mine
        return float(off @ off) < 0.25 * float(side @ side)

    def _hand_over(self, answer: Detection, image: NDArray[np.uint8], pose: Pose) -> None:
        self._pose = pose
        corners = np.array(answer.corners, dtype=np.float64)
        self.tracker.start(image, corners)
        self._corners[:] = corners
        self.ok, self.searching, self._lost = True, False, 0
        self.confidence = answer.confidence


def _is_sound(answer: Detection) -> bool:
    """Return whether an answer can be the target's."""
    finite = np.isfinite(answer.corners).all() and 0.0 <= answer.confidence <= 1.0
    return answer.label == TARGET_LABEL and bool(finite) and is_convex(np.array(answer.corners))


class SearchReport:
    """What is recorded and observed of a search."""

    def __init__(self, search: SearchInLoop, seen: Array, *, told_m: Array, late: int) -> None:
        """Take the part of the observation, (SEARCH_NUMBERS,), and how many steps images are late.

        `told_m` is where the target is said to be, (2,) [m] north and east of the start.
        """
        self._search, self._seen = search, seen
        seen[:2] = told_m
        self._confidences: deque[float] = deque(maxlen=late + 1)

    def measure(self, row: Array) -> None:
        """Fill the row and the observation."""
        search, columns = self._search, row[_FOUND]
        columns[:_ANSWER] = search.searching, search.looked, search.confidence
        if search.best is None:
            columns[_ANSWER:] = np.nan
        else:
            columns[_ANSWER:-1] = search.best.corners.ravel()
            columns[-1] = search.best.confidence
        self._confidences.append(search.confidence)
        self._seen[2] = self._confidences[0]
