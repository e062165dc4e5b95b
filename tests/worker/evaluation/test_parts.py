"""Runs with further programs: each in a box of its own, all of which are closed in the end."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from seamark.programs import trial_limits
from seamark.programs.preparation import PreparedProgram, prepare
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.languages import editor_starters
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import Outcome, Verdict
from seamark.sim import registry
from seamark.worker.evaluation.evaluation import Evaluation
from seamark.worker.evaluation.job import Job, PartProgram
from seamark.worker.evaluation.local import Callbacks, evaluate_locally
from seamark.worker.ipc.outcomes import RunOutcome
from tests.worker.evaluation import team_benchmark
from tests.worker.evaluation.fakes import SLOW, FakeBox, FakeBoxes, FakeListener

NAME = team_benchmark.NAME
CRASHED = Outcome(verdict=Verdict.USER_ERROR, sentence="The program was ended by SIGSEGV.")
CONTROLLER = """
class Controller:
    def __init__(self, config):
        print("steering")

    def reset(self, level):
        pass

    def step(self, observation):
        return 0.0, 0.0, 0.0, 0.0
"""
DETECTOR = """
import time

PARAMETERS = {{"share": 0.25}}
CORNERS = [(1, 1), (9, 1), (9, 9), (1, 9)]

class Detector:
    def __init__(self, config):
        print("looking for", config["share"])
        self.images = 0

    def detect(self, image):
        self.images += 1
        {answer}
"""
TRACKER = """
class Tracker:
    def __init__(self, config):
        pass

    def start(self, image, corners):
        print("started", image.shape)

    def update(self, image):
        return None
"""


@pytest.fixture(autouse=True)
def _team_benchmark(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(registry.BENCHMARKS, NAME, team_benchmark.PATH)


@pytest.fixture
def team(tmp_path: Path) -> Job:
    """Two short trials of an uploaded controller with both parts."""
    program = tmp_path / "program"
    program.write_text("not read")
    parts = tuple(
        PartProgram(role=role, program=program, filename=f"my_{role}.py", language="python")
        for role in ("detector", "tracker")
    )
    return Job(
        benchmark=NAME,
        config=dict(team_benchmark.QUICK),
        seeds=(5, 5),
        controller="upload",
        program=program,
        parts=parts,
    )


def evaluate(job: Job, *boxes: FakeBox) -> RunOutcome:
    outcome = Evaluation(job, FakeListener(), FakeBoxes(*boxes)).run()
    assert all(box.closed for box in boxes)
    return outcome


def test_a_job_survives_its_packet(team: Job) -> None:
    assert Job.from_json(team.to_json()) == team


def test_each_program_has_a_box_of_its_own_in_each_trial(team: Job) -> None:
    boxes = [FakeBox() for _ in range(6)]

    outcome = evaluate(team, *boxes)

    assert outcome.failure is None
    assert all(box.steps for box in boxes)


def test_parts_beside_a_built_in_controller_have_boxes_alone(team: Job) -> None:
    outcome = evaluate(replace(team, program=None, controller="pi"), *(FakeBox() for _ in range(4)))

    assert outcome.failure is None
    assert outcome.manifest is not None
    assert (outcome.manifest["controller"], outcome.manifest["program_sha256"]) == ("pi", None)
    assert set(outcome.manifest["parts"]) == {"detector", "tracker"}
    assert not outcome.manifest["same_bits_on_every_cpu"]


@pytest.mark.parametrize("role", ["controller", "detector", "tracker"])
def test_the_program_that_fails_is_named_and_no_box_stays_open(team: Job, role: str) -> None:
    failing = FakeBox(ends_at=3, outcome=CRASHED)
    others = {name: FakeBox() for name in ("controller", "detector", "tracker")}
    boxes = others | {role: failing}

    outcome = evaluate(team, *boxes.values())

    assert (outcome.failure, outcome.sentence) == (
        "user_error",
        f"The {role} was ended by SIGSEGV.",
    )


def test_a_slow_host_gives_all_programs_new_boxes(team: Job) -> None:
    first = [FakeBox(), FakeBox(ends_at=3, outcome=SLOW), FakeBox()]

    outcome = evaluate(replace(team, seeds=(5,)), *first, *(FakeBox() for _ in range(3)))

    assert outcome.failure is None


def prepared(role: str, source: str, suffix: str = ".py") -> PreparedProgram:
    program = prepare(source.encode(), f"my_{role}{suffix}", role=role)
    program.require_clean()
    return program


def run(
    isolation: IsolationLevel,
    parts: Mapping[str, PreparedProgram],
    *,
    trials: int = 1,
    controller: str = "",
) -> tuple[RunOutcome, str]:
    log = bytearray()
    outcome = evaluate_locally(
        NAME,
        team_benchmark.QUICK,
        seed=3,
        trials=trials,
        controller=controller or prepared("controller", CONTROLLER),
        parts=parts,
        callbacks=Callbacks(log=log.extend),
        isolation=isolation,
        processes=2,
    )
    return outcome, log.decode()


@pytest.mark.host
@pytest.mark.slow
def test_the_log_says_which_program_has_printed_what(isolation: IsolationLevel) -> None:
    parts = {
        "tracker": prepared("tracker", TRACKER),
        "detector": prepared("detector", DETECTOR.format(answer="return [('cat', CORNERS, 1.0)]")),
    }

    outcome, log = run(isolation, parts, trials=2)

    assert (outcome.failure, outcome.sentence) == (None, "")
    assert log.count("[controller]\nsteering\n") == 2
    assert log.count("[detector]\nlooking for 0.25\n") == 2
    assert log.count("[tracker]\nstarted (60, 80)\n") == 2
    assert log.count("answers of detect() have labels that are no class: cat") == 2


@pytest.mark.host
@pytest.mark.slow
def test_parallel_trials_with_a_built_in_controller_share_no_box(isolation: IsolationLevel) -> None:
    parts = {"detector": prepared("detector", DETECTOR.format(answer="return []"))}

    outcome, log = run(isolation, parts, trials=3, controller="pi")

    assert (outcome.failure, outcome.sentence) == (None, "")
    assert log.count("looking for 0.25") == 3


@pytest.mark.host
@pytest.mark.slow
def test_a_part_may_be_in_another_language(isolation: IsolationLevel) -> None:
    starter = editor_starters("detector")["c"]

    outcome, _ = run(isolation, {"detector": prepared("detector", starter.text(), ".c")})

    assert (outcome.failure, outcome.sentence) == (None, "")


@pytest.mark.host
@pytest.mark.slow
@pytest.mark.parametrize(
    ("answer", "failure", "sentence"),
    [
        ("time.sleep(1e6)", "time_limit", "The detector: detect(image) did not return within 2 s."),
        ("while True: pass", "time_limit", "The detector: detect(image) used"),
        ("raise ValueError('no idea')", "user_error", "The detector: ValueError: no idea"),
        ("import os; os._exit(3)", "user_error", "The detector exited (exit code 3)"),
        ("return 'here'", "protocol_error", "The detector: "),
    ],
)
def test_a_hostile_part_ends_the_run_by_its_name(
    isolation: IsolationLevel, answer: str, failure: str, sentence: str, monkeypatch: Any
) -> None:
    # Twice a program that sleeps may have been starved: ten seconds each time, usually.
    monkeypatch.setattr(trial_limits, "for_trial", lambda _s: Limits(step_wall_s=2.0))
    hostile = DETECTOR.format(answer=answer)

    outcome, _ = run(isolation, {"detector": prepared("detector", hostile)})

    assert outcome.failure == failure
    assert outcome.sentence.startswith(sentence)


@pytest.mark.host
@pytest.mark.slow
def test_a_part_that_does_not_compile_is_named(isolation: IsolationLevel) -> None:
    outcome, _ = run(isolation, {"detector": prepared("detector", "int broken(", ".c")})

    assert outcome.failure == "compile_error"
    assert outcome.sentence.startswith("The detector: ")
