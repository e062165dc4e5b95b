import math
from dataclasses import replace

import numpy as np

from seamark.sim.recording.telemetry import digest
from seamark.worker.evaluation.evaluation import Evaluation
from seamark.worker.evaluation.job import Job
from seamark.worker.ipc.outcomes import RunOutcome
from tests.worker.evaluation.fakes import SLOW, FakeBox, FakeBoxes, FakeListener


def _evaluate(job: Job, *boxes: FakeBox) -> tuple[RunOutcome, FakeListener]:
    listener = FakeListener()
    outcome = Evaluation(job, listener, FakeBoxes(*boxes)).run()
    assert all(box.closed for box in boxes)
    return outcome, listener


def test_each_trial_has_a_box_of_its_own(job: Job) -> None:
    outcome, listener = _evaluate(job, FakeBox(), FakeBox())

    assert (outcome.failure, listener.ended) == (None, [0, 1])
    assert outcome.digest == digest(np.concatenate(listener.received))


def test_a_trial_on_a_slow_host_starts_again_and_leaves_no_trace(job: Job) -> None:
    plain, _ = _evaluate(job, FakeBox(), FakeBox())
    outcome, listener = _evaluate(job, FakeBox(), FakeBox(ends_at=50), FakeBox())

    assert (outcome.failure, listener.restarted) == (None, [1])
    assert outcome.digest == plain.digest == digest(np.concatenate(listener.received))


def test_the_second_time_it_is_the_programs_failure(job: Job) -> None:
    outcome, listener = _evaluate(job, FakeBox(ends_at=50), FakeBox(ends_at=60))

    assert (outcome.failure, outcome.sentence) == ("time_limit", "too slow")
    assert outcome.metrics is None
    assert outcome.digest == digest(np.concatenate(listener.received))


def test_a_program_that_fails_by_itself_is_not_retried(job: Job) -> None:
    own = replace(SLOW, suspect_host=False)

    outcome, listener = _evaluate(job, FakeBox(ends_at=50, outcome=own))

    assert (outcome.failure, listener.restarted) == ("time_limit", [])


def test_numbers_that_are_not_finite_end_the_trial_at_once(job: Job) -> None:
    outcome, listener = _evaluate(job, FakeBox(command=(math.nan, 0.0, 0.0, 0.0)))

    assert (outcome.failure, outcome.metrics) == ("benchmark_error", None)
    assert "At 0 s of simulated time" in outcome.sentence
    assert listener.received == []  # the control step that diverged is no data


def test_hidden_seeds_are_not_in_the_manifest(job: Job) -> None:
    outcome, _ = _evaluate(replace(job, seeds=(987654321, 987654322), ranked=True), *_two())

    assert "98765432" not in str(outcome)


def test_the_manifest_of_a_ranked_run_discloses_the_seeds_that_concern_it_alone(job: Job) -> None:
    ranked = replace(job, benchmark="currents-v2", seeds=(987654321, 987654322), ranked=True)

    outcome, _ = _evaluate(ranked, *_two())

    assert outcome.manifest["seed"] is None
    assert outcome.manifest["seeds"] == [987654321, 987654322]


def test_the_manifest_of_a_practice_run_has_its_one_seed(job: Job) -> None:
    outcome, _ = _evaluate(job, *_two())

    assert (outcome.manifest["seed"], outcome.manifest["seeds"]) == (5, None)


def _two() -> tuple[FakeBox, FakeBox]:
    return FakeBox(), FakeBox()


def test_a_job_travels_unchanged(job: Job) -> None:
    assert Job.from_json(job.to_json()) == job
