"""Trials in processes of their own: the listener cannot tell, and no process outlives the run."""

import os
import signal
import time
from collections.abc import Iterator
from contextlib import closing
from dataclasses import asdict, replace
from typing import Any

import numpy as np
import pytest

from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.languages.python import PYTHON
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import Outcome, SandboxBroken
from seamark.sim.engine.program import Command
from seamark.sim.recording.telemetry import STEP_US, WIDTH
from seamark.worker.evaluation.cores import Cores
from seamark.worker.evaluation.evaluation import Evaluation
from seamark.worker.evaluation.job import Job
from seamark.worker.evaluation.local import Callbacks, Progress, evaluate_locally
from seamark.worker.evaluation.parallel_trials import ParallelTrials, TrialBroken
from seamark.worker.ipc.listener import Listener
from seamark.worker.ipc.outcomes import RunOutcome, TrialOutcome
from tests.worker.conftest import SHORT
from tests.worker.evaluation.fakes import SLOW, FakeBox, FakeListener
from tests.worker.processes import children

_ANY: Any = "a result"


def two_cores() -> Cores:
    """Two cores; on a machine with one, trials run one after the other, and the tests hold too."""
    return Cores(None, sorted(os.sched_getaffinity(0))[:2])


@pytest.fixture
def job(job: Job) -> Job:
    return replace(job, seeds=(5, 6, 7))


class Logging(FakeListener):
    """Keeps the log too."""

    def __init__(self) -> None:
        super().__init__()
        self.text = b""

    def log(self, text: bytes) -> None:
        self.text += text


def received_here(
    processes: int,
    controller: str | tuple[bytes, str] = "pi",
    isolation: IsolationLevel = IsolationLevel.NONE,
) -> tuple[RunOutcome, list[Any]]:
    received, progress = list[Any](), list[Progress]()
    callbacks = Callbacks(  # rows one by one: how many come at once does depend on the processes
        rows=lambda rows: received.extend(np.delete(rows, STEP_US, axis=1).tolist()),
        log=received.append,
        progress=progress.append,
        trial_restarted=received.append,
    )
    order = {"seed": 3, "trials": 3, "callbacks": callbacks, "processes": processes}
    outcome = evaluate_locally(
        "currents-v1", SHORT, controller=controller, isolation=isolation, **order
    )
    return outcome, [*received, progress[-1]]


@pytest.mark.slow
def test_what_is_received_does_not_depend_on_the_number_of_processes() -> None:
    one, received_from_one = received_here(1)
    two, received_from_two = received_here(2)

    assert asdict(two) == asdict(one)
    assert received_from_two == received_from_one


@pytest.mark.host
def test_an_upload_gives_the_same_in_warm_boxes_and_leaves_none(
    isolation: IsolationLevel,
) -> None:
    before = children()
    program = (PYTHON.self_test.upload(), "half.py")

    one, received_from_one = received_here(1, program, isolation)
    two, received_from_two = received_here(2, program, isolation)

    assert (one.failure, one.digest, one.metrics) == (two.failure, two.digest, two.metrics)
    assert (one.failure, received_from_two) == (None, received_from_one)
    assert children() == before


@pytest.mark.parametrize("suspect", [False, True])
def test_a_program_that_ends_early_ends_the_run_as_one_after_the_other(
    job: Job, suspect: bool
) -> None:
    outcome = Outcome(verdict=SLOW.verdict, sentence="too slow", suspect_host=suspect)

    def make(language: str, limits: Limits) -> FakeBox:
        return FakeBox(ends_at=50, outcome=outcome)

    one, two = FakeListener(), FakeListener()
    in_turn = Evaluation(job, one, make).run()
    beside = Evaluation(job, two, make, cores=two_cores()).run()

    assert beside == in_turn
    assert (two.restarted, two.ended) == (one.restarted, one.ended) == ([0] if suspect else [], [])
    assert len(np.concatenate(two.received)) == len(np.concatenate(one.received)) == 50


class Deadly(FakeBox):
    """Kills the process of its trial in the middle of it, as the kernel may."""

    def step(self, values: Any) -> Command:
        if self.steps == 30:
            os.kill(os.getpid(), signal.SIGKILL)
        return super().step(values)


def test_a_trial_that_is_killed_is_a_failure_of_the_platform_and_leaves_no_process(
    job: Job,
) -> None:
    listener, before = FakeListener(), children()

    with pytest.raises(TrialBroken, match="trial 0 died: SIGKILL"):
        Evaluation(job, listener, lambda *_: Deadly(), cores=two_cores()).run()

    assert len(np.concatenate(listener.received)) == 20  # what had come by then is not lost
    assert children() == before


def test_a_trial_that_ends_without_a_result_says_how(job: Job) -> None:
    with pytest.raises(TrialBroken, match="trial 0 died: exit code 3"):
        Evaluation(job, FakeListener(), lambda *_: os._exit(3), cores=two_cores()).run()


def test_a_trial_that_breaks_before_its_program_starts_says_why() -> None:
    nowhere = Cores(None, [4095])

    with pytest.raises(TrialBroken, match="OSError"):
        list(ParallelTrials(talkative, nowhere, 1).outcomes(FakeListener()))


def test_a_broken_box_and_an_error_in_our_code_are_distinguished(job: Job) -> None:
    def broken(language: str, limits: Limits) -> FakeBox:
        raise SandboxBroken("no room")

    with pytest.raises(SandboxBroken, match="no room"):
        Evaluation(job, FakeListener(), broken, cores=two_cores()).run()
    with pytest.raises(TrialBroken, match="ZeroDivisionError"):
        Evaluation(job, FakeListener(), lambda *_: FakeBox(1 // 0), cores=two_cores()).run()


def talkative(trial: int, listener: Listener) -> TrialOutcome:
    """The later the trial, the more it sends and the sooner it ends."""
    time.sleep(0.05 * (3 - trial))
    for at in range(20 * (1 + trial)):
        listener.rows(np.full((300, WIDTH), 100.0 * trial + at))
        listener.log(f"{trial}:{at} ".encode())
    return TrialOutcome(result=_ANY)


@pytest.mark.slow
@pytest.mark.parametrize("buffer_max", [0, 2**20, 2**26])
def test_everything_arrives_in_the_order_of_the_trials_however_small_the_buffer(
    buffer_max: int,
) -> None:
    listener = Logging()

    trials = ParallelTrials(talkative, two_cores(), 4, buffer_max=buffer_max)
    outcomes = list(trials.outcomes(listener))

    wanted = [(trial, at) for trial in range(4) for at in range(20 * (1 + trial))]
    assert [rows[0, 0] for rows in listener.received] == [100.0 * t + at for t, at in wanted]
    assert listener.text == "".join(f"{t}:{at} " for t, at in wanted).encode()
    assert [outcome.result for outcome in outcomes] == [_ANY] * 4


def endless(trial: int, listener: Listener) -> TrialOutcome:
    """Trial 0 ends as soon as trial 1 runs; the others run until they are terminated."""
    if trial > 0:
        os.write(BEGUN[1], b"x")
        try:
            time.sleep(600)
        finally:
            os.write(BEGUN[1], b"y")
    assert os.read(BEGUN[0], 1) == b"x"
    return TrialOutcome(result=_ANY)


BEGUN = [-1, -1]


@pytest.fixture
def pipe() -> Iterator[None]:
    BEGUN[:] = os.pipe()
    yield
    for descriptor in BEGUN:
        os.close(descriptor)


@pytest.mark.usefixtures("pipe")
def test_closing_the_generator_early_stops_the_trials_in_order() -> None:
    if two_cores().count < 2:
        pytest.skip("one core: no other trial runs meanwhile")
    before = children()

    with closing(ParallelTrials(endless, two_cores(), 3).outcomes(FakeListener())) as outcomes:
        next(outcomes)

    os.set_blocking(BEGUN[0], False)
    assert b"y" in os.read(BEGUN[0], 10)  # it ended its box before itself
    assert children() == before


@pytest.mark.slow
def test_the_outcomes_of_all_trials_are_added_up(job: Job) -> None:
    outcome = Evaluation(job, FakeListener(), lambda *_: FakeBox(), cores=two_cores()).run()

    assert (outcome.failure, outcome.usage["cpu_s"]) == (None, 0.0)
    assert [trial["trial"] for trial in (outcome.metrics or {})["trials"]] == [0, 1, 2]
