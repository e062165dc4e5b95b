import math
import socket
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from seamark.sim.recording.telemetry import digest
from seamark.worker.evaluation.evaluation import Ending, Evaluation
from seamark.worker.evaluation.job import Job
from seamark.worker.ipc import messages
from seamark.worker.ipc.messages import Kind, Reader, StreamBroken
from tests.worker.conftest import SHORT
from tests.worker.fakes import SLOW, FakeBox, FakeBoxes, FakeListener


@pytest.fixture
def job(tmp_path: Path) -> Job:
    program = tmp_path / "program"
    program.write_text("the fake box does not read it")
    return Job(
        benchmark="currents-v1",
        config=dict(SHORT),
        seeds=(5, 5),
        shown_seed=5,
        controller="upload",
        program=program,
    )


def _evaluate(job: Job, *boxes: FakeBox) -> tuple[Ending, FakeListener]:
    listener = FakeListener()
    ending = Evaluation(job, listener, FakeBoxes(*boxes)).run()
    assert all(box.closed for box in boxes)
    return ending, listener


def test_each_trial_has_a_box_of_its_own(job: Job) -> None:
    ending, listener = _evaluate(job, FakeBox(), FakeBox())

    assert (ending.verdict, listener.ended) == ("ok", [0, 1])
    assert ending.digest == digest(np.concatenate(listener.heard))


def test_a_trial_on_a_slow_host_is_done_again_and_leaves_no_trace(job: Job) -> None:
    plain, _ = _evaluate(job, FakeBox(), FakeBox())
    ending, listener = _evaluate(job, FakeBox(), FakeBox(ends_at=50), FakeBox())

    assert (ending.verdict, listener.cuts) == ("ok", [1])
    assert ending.digest == plain.digest == digest(np.concatenate(listener.heard))


def test_the_second_time_it_is_the_programs_verdict(job: Job) -> None:
    ending, listener = _evaluate(job, FakeBox(ends_at=50), FakeBox(ends_at=60))

    assert (ending.verdict, ending.sentence) == ("time_limit", "too slow")
    assert ending.metrics is None
    assert ending.digest == digest(np.concatenate(listener.heard))


def test_a_program_that_fails_by_itself_is_not_tried_again(job: Job) -> None:
    own = replace(SLOW, suspect_host=False)

    ending, listener = _evaluate(job, FakeBox(ends_at=50, outcome=own))

    assert (ending.verdict, listener.cuts) == ("time_limit", [])


def test_numbers_that_are_not_finite_end_the_trial_at_once(job: Job) -> None:
    ending, listener = _evaluate(job, FakeBox(command=(math.nan, 0.0, 0.0, 0.0)))

    assert (ending.verdict, ending.metrics) == ("benchmark_error", None)
    assert "At 0 s of simulated time" in ending.sentence
    assert listener.heard == []  # the tick that broke is no data


def test_hidden_seeds_are_not_in_the_manifest(job: Job) -> None:
    ending, _ = _evaluate(replace(job, seeds=(987654321, 987654322), shown_seed=None), *_two())

    assert "98765432" not in str(ending)


def _two() -> tuple[FakeBox, FakeBox]:
    return FakeBox(), FakeBox()


def test_a_job_travels_unchanged(job: Job) -> None:
    assert Job.from_json(job.to_json()) == job


def test_messages_arrive_whole_and_in_order() -> None:
    mine, theirs = socket.socketpair()
    with mine, theirs:
        messages.send(theirs, Kind.ROWS, b"x" * 5000)
        messages.send(theirs, Kind.TRIAL, {"trial": 1})
        reader = Reader(mine)
        found = list(reader.read(1.0))

    assert [frame.kind for frame in found] == [Kind.ROWS, Kind.TRIAL]
    assert found[1].json() == {"trial": 1}


def test_what_is_no_message_is_our_failure() -> None:
    mine, theirs = socket.socketpair()
    with mine, theirs:
        theirs.sendall(b"?\0\0\0\0")

        with pytest.raises(StreamBroken):
            list(Reader(mine).read(1.0))
