"""A detector finds the target for the tracker, which has nothing before that."""

from collections.abc import Sequence

import numpy as np
import pytest
from numpy.typing import NDArray

from seamark.sim.benchmarks.mission_v1.experiment import EXPERIMENT
from seamark.sim.benchmarks.mission_v1.settings import MissionConfiguration
from seamark.sim.detectors import Detection
from seamark.sim.engine.search_in_loop import PATIENCE_S, SearchInLoop
from seamark.sim.engine.team import Team
from seamark.sim.recording.telemetry import INDEX, SEARCH_INDEX, Rows
from seamark.sim.trackers import Track, Window

CONFIG = MissionConfiguration.read(
    {"levels": [0.1], "loop1_values": [0.5], "level_duration_s": 6.0, "detector_period_s": 0.5}
)
PERIOD = 10  # steps
HERE = np.array([[100.0, 100.0], [130.0, 100.0], [130.0, 120.0], [100.0, 120.0]])
THERE = HERE + np.array([80.0, 40.0])


def box(confidence: float, corners: NDArray[np.float64] = HERE) -> Detection:
    return Detection("box", corners, confidence)


class Answers:
    """A detector that answers what it was given, one list after the other, and the last again."""

    def __init__(self, *answers: Sequence[Detection]) -> None:
        self._answers = [list(one) for one in answers]
        self.asked = 0

    def detect(self, image: NDArray[np.uint8]) -> list[Detection]:
        assert image.shape == (240, 320)
        self.asked += 1
        return self._answers[min(self.asked, len(self._answers)) - 1]


class Follower:
    """A tracker that reports what it was started with, for as many images as it was told."""

    def __init__(self, images: int = 1_000_000) -> None:
        self.starts: list[NDArray[np.float64]] = []
        self._images, self._left = images, 0

    def start(self, image: NDArray[np.uint8], corners: NDArray[np.float64]) -> None:
        self.starts.append(corners.copy())
        self._left = self._images

    def window(self) -> Window:
        return (0, 0, 8, 8)

    def update(self, image: NDArray[np.uint8]) -> Track:
        self._left -= 1
        return Track(self.starts[-1], ok=self._left >= 0, residual=0.0, iterations=1)


def rows_of(detector: Answers, tracker: Follower, **settings: float) -> Rows:
    config = MissionConfiguration.read({**CONFIG.model_dump(), **settings})
    parts: list[Rows] = []
    program = EXPERIMENT.built_in("nothing", config)
    team = Team(program, tracker=tracker, detector=detector)
    EXPERIMENT.level(config, team, seed=1, trial=0, level=0).run(parts.append)
    return np.concatenate(parts)


def column(rows: Rows, name: str) -> NDArray[np.float64]:
    found: NDArray[np.float64] = rows[:, {**INDEX, **SEARCH_INDEX}[name]]
    return found


def test_the_detector_gets_an_image_in_each_period_and_each_answer_is_recorded() -> None:
    detector = Answers([], [box(0.1)])
    rows = rows_of(detector, Follower())

    looked = np.flatnonzero(column(rows, "looked"))
    assert looked.tolist() == list(range(0, len(rows), PERIOD))
    assert detector.asked == len(looked)
    found = np.flatnonzero(np.isfinite(column(rows, "found_confidence")))
    assert found.tolist() == looked[1:].tolist()
    assert rows[PERIOD, SEARCH_INDEX["found_x0"] : SEARCH_INDEX["found_confidence"] + 1] == (
        pytest.approx([*HERE.ravel(), 0.1])
    )


def test_the_tracker_starts_from_the_first_answer_that_is_confident_enough() -> None:
    tracker = Follower()
    rows = rows_of(Answers([], [box(0.2)], [box(0.3)]), tracker)

    searching = column(rows, "searching")
    assert searching[: 2 * PERIOD].min() == 1.0
    assert searching[2 * PERIOD :].max() == 0.0
    assert np.array_equal(column(rows, "tracker_ok"), 1.0 - searching)
    assert [start.tolist() for start in tracker.starts] == [HERE.tolist()]
    assert set(column(rows, "confidence")[2 * PERIOD :]) == {0.3}


@pytest.mark.parametrize(
    "answer",
    [
        Detection("amphora", HERE, 0.9),
        Detection("no such thing", HERE, 0.9),
        box(0.9, np.full((4, 2), np.nan)),
        box(0.9, HERE[::-1]),  # counterclockwise: seen from below
        box(0.9, HERE[[0, 2, 1, 3]]),  # no quadrilateral
        box(float("nan")),
        box(7.0),
    ],
)
def test_an_answer_that_cannot_be_the_targets_starts_nothing(answer: Detection) -> None:
    tracker = Follower()
    rows = rows_of(Answers([answer]), tracker)

    assert tracker.starts == []
    assert column(rows, "searching").min() == 1.0
    assert not np.isfinite(column(rows, "found_confidence")).any()


def test_of_many_answers_the_most_confident_counts() -> None:
    tracker = Follower()
    rows_of(Answers([box(0.5), box(0.8, THERE), box(0.6)]), tracker)

    assert tracker.starts[0].tolist() == THERE.tolist()


def test_the_answer_on_what_is_tracked_says_how_confident_the_detector_is_by_now() -> None:
    tracker = Follower()
    rows = rows_of(Answers([box(0.5)], [box(0.7)], [], [box(0.1)]), tracker)

    confidence = column(rows, "confidence")
    assert confidence[::PERIOD][:5].tolist() == [0.5, 0.7, 0.7, 0.1, 0.1]
    assert len(tracker.starts) == 1


def test_the_tracker_leaves_what_it_has_for_a_clearly_more_confident_answer_only() -> None:
    tracker = Follower()
    answers = [box(0.5)], [box(0.5), box(0.55, THERE)], [box(0.5), box(0.65, THERE)]
    rows = rows_of(Answers(*answers), tracker)

    assert [start.tolist() for start in tracker.starts] == [HERE.tolist(), THERE.tolist()]
    assert column(rows, "confidence")[2 * PERIOD] == 0.65


def test_what_the_tracker_has_lost_for_long_is_looked_for_again() -> None:
    tracker = Follower(images=15)
    rows = rows_of(Answers([box(0.9)], [], [], [], [], [], [box(0.8)]), tracker)

    searching = column(rows, "searching")
    lost = 15 + 1 + round(PATIENCE_S / CONFIG.control_period_s)
    assert searching[:lost].max() == 0.0
    assert searching[lost : 6 * PERIOD].min() == 1.0
    assert column(rows, "confidence")[lost : 6 * PERIOD].max() == 0.0
    assert searching[6 * PERIOD] == 0.0


def test_what_is_lost_and_found_again_at_once_needs_no_search() -> None:
    tracker = Follower(images=15)
    rows = rows_of(Answers([box(0.9)], [box(0.9)], [box(0.9, THERE)]), tracker)

    assert column(rows, "searching").max() == 0.0
    assert tracker.starts[1].tolist() == THERE.tolist()


def test_the_built_in_programs_take_part_where_a_team_has_none() -> None:
    program = EXPERIMENT.built_in("nothing", CONFIG)
    whole = [program, Team(program), Team(program, detector=Answers([]))]
    trackings = [
        EXPERIMENT.level(CONFIG, one, seed=1, trial=0, level=0)._world.tracking for one in whole
    ]

    assert all(isinstance(tracking, SearchInLoop) for tracking in trackings)
    kinds = [type(tracking._detector) for tracking in trackings]
    assert kinds[0] is kinds[1]
    assert kinds[2] is Answers
