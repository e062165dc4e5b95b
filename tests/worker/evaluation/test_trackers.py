"""Uploaded trackers through the whole chain, in real boxes: every bad answer has a clear cause."""

from pathlib import Path

import numpy as np
import pytest

from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.languages import editor_starters
from seamark.sandbox.limits import Limits
from seamark.sandbox.protocol.answers import Loss
from seamark.sim.recording.telemetry import INDEX, Rows
from seamark.worker.evaluation.evaluation import Evaluation
from seamark.worker.evaluation.job import Job
from seamark.worker.evaluation.local import Callbacks, evaluate_locally
from seamark.worker.evaluation.program_adapters import TrackerAdapter
from seamark.worker.ipc.outcomes import RunOutcome
from tests.worker.evaluation.fakes import FakeBox, FakeListener

NAME = "visibility-v1"
SHORT = {"sweep_to": 0.5, "sweep_step": 0.5, "level_duration_s": 2.0}
LARGE = {"camera_width_px": 640, "camera_height_px": 480, "camera_focal_px": 514.7}
SQUARE = np.array([[10.0, 10.0], [50.0, 10.0], [50.0, 30.0], [10.0, 30.0]])
PROGRAM = """
class Tracker:
    def __init__(self, config):
        pass

    def start(self, image, corners):
        self.corners = corners.copy()

    def update(self, image):
        {answer}
"""


class Received:
    """What a run sent."""

    def __init__(self) -> None:
        self.parts: list[Rows] = []
        self.text = b""

    def log(self, text: bytes) -> None:
        self.text += text

    @property
    def rows(self) -> Rows:
        return np.concatenate(self.parts)


def evaluated(
    source: str, isolation: IsolationLevel, **config: object
) -> tuple[RunOutcome, Received]:
    received = Received()
    callbacks = Callbacks(
        rows=received.parts.append,
        log=received.log,
        trial_restarted=lambda trial: received.parts.clear(),
    )
    settings = SHORT | config
    program = (source.encode(), "mine.py")
    outcome = evaluate_locally(
        NAME,
        settings,
        seed=3,
        controller=program,
        callbacks=callbacks,
        isolation=isolation,
        processes=1,
    )
    return outcome, received


@pytest.mark.host
@pytest.mark.parametrize("size", [{}, LARGE], ids=["320x240", "640x480"])
def test_the_template_tracker_follows_its_target(
    isolation: IsolationLevel, size: dict[str, object]
) -> None:
    outcome, _ = evaluated(editor_starters("tracker")["python"].text(), isolation, **size)

    assert (outcome.failure, outcome.sentence) == (None, "")
    assert outcome.metrics is not None
    assert outcome.metrics["overall"]["p1_percent"] > 90.0


@pytest.mark.host
@pytest.mark.parametrize(
    ("answer", "failure", "explanation"),
    [
        ("return self.corners[:3]", "protocol_error", "(3, 2)"),
        ("return 'here'", "protocol_error", "str"),
        ("raise ValueError('no idea')", "user_error", "no idea"),
        ("while True: pass", "time_limit", "update(image)"),
    ],
)
def test_an_invalid_answer_ends_the_run_with_its_reason(
    isolation: IsolationLevel, answer: str, failure: str, explanation: str
) -> None:
    outcome, received = evaluated(PROGRAM.format(answer=answer), isolation)

    assert outcome.failure == failure
    assert explanation in outcome.sentence + outcome.traceback
    assert len(received.rows) == 1  # the row of the start: the data so far is kept


@pytest.mark.host
def test_corners_that_are_no_convex_quadrilateral_count_as_lost_and_the_log_says_so(
    isolation: IsolationLevel,
) -> None:
    outcome, received = evaluated(
        PROGRAM.format(answer="return self.corners[[0, 2, 1, 3]]"), isolation
    )

    assert outcome.failure is None
    assert received.rows[:, INDEX["tracker_ok"]].tolist() == ([1.0] + [0.0] * 39) * 2
    assert b"[78 of 78 answers of update() were not a convex quadrilateral," in received.text
    assert outcome.metrics is not None
    assert outcome.metrics["rankable"] is False


@pytest.mark.host
@pytest.mark.parametrize("answer", ["self.corners * float('nan')", "self.corners + 1e9"])
def test_corners_out_of_range_count_as_lost_and_the_log_says_so(
    isolation: IsolationLevel, answer: str
) -> None:
    outcome, received = evaluated(PROGRAM.format(answer=f"return {answer}"), isolation)

    assert outcome.failure is None
    assert received.rows[:, INDEX["tracker_ok"]].tolist() == ([1.0] + [0.0] * 39) * 2
    assert b"[78 of 78 answers of update() were not finite or beyond 1e+06 px" in received.text


@pytest.mark.host
def test_a_tracker_sees_no_truth_but_the_corners_of_its_start(isolation: IsolationLevel) -> None:
    snoop = "print(sorted(vars(self)), sorted(k for k in self.config if 'seed' in k)); return None"
    source = PROGRAM.format(answer=snoop).replace("        pass", "        self.config = config")

    outcome, received = evaluated(source, isolation)

    assert outcome.failure is None
    assert set(received.text.splitlines()) == {b"['config', 'corners'] []"}


class Answering(FakeBox):
    """A box whose tracker gives the answers of a list, over and over."""

    def __init__(self, *answers: object) -> None:
        super().__init__()
        self._answers = answers

    def update(self, image: object) -> object:  # type: ignore[override]
        self.steps += 1
        return self._answers[self.steps % len(self._answers)]


def test_an_answer_is_adopted_and_none_is_a_loss_at_the_last_position() -> None:
    tracker = TrackerAdapter(Answering(Loss.REPORTED, SQUARE + 1.0))
    tracker.start(np.zeros((60, 80), np.uint8), SQUARE)

    first, second = (tracker.update(np.zeros((60, 80), np.uint8)) for _ in range(2))

    assert (first.ok, second.ok) == (True, False)
    assert np.array_equal(first.corners, SQUARE + 1.0)
    assert np.array_equal(second.corners, SQUARE + 1.0)
    assert tracker.window() == (0, 0, 80, 60)
    assert tracker.note() == ""


def test_every_kind_of_answer_that_cannot_be_the_target_is_counted() -> None:
    tracker = TrackerAdapter(Answering(Loss.OUT_OF_RANGE, SQUARE[::-1], Loss.REPORTED, SQUARE))
    tracker.start(np.zeros((60, 80), np.uint8), SQUARE)

    tracks = [tracker.update(np.zeros((60, 80), np.uint8)) for _ in range(8)]

    assert [track.ok for track in tracks] == [False, False, True, False] * 2
    assert tracker.note().splitlines() == [
        "[2 of 8 answers of update() were not finite or beyond 1e+06 px: they count as lost.]",
        "[2 of 8 answers of update() were not a convex quadrilateral, clockwise like the corners "
        "of start(): they count as lost.]",
    ]


def test_a_tracker_in_a_box_gives_the_same_bytes_one_after_the_other(tmp_path: Path) -> None:
    program = tmp_path / "program"
    program.write_text("the fake box does not read it")
    job = Job(
        benchmark=NAME,
        config=dict(SHORT),
        seeds=(3,),
        controller="upload",
        program=program,
    )

    def make(language: str, limits: Limits) -> FakeBox:
        return FakeBox()

    outcomes = [Evaluation(job, FakeListener(), make).run() for _ in range(2)]

    assert outcomes[0].digest == outcomes[1].digest
    assert [outcome.failure for outcome in outcomes] == [None, None]
