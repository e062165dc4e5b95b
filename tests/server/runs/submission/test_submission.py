import time
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import update

from seamark.sandbox.languages import LANGUAGES
from seamark.server.database.tables import Run, Worker
from seamark.server.messaging import workers
from seamark.server.runs.ending import results
from seamark.server.runs.leaderboard import leaderboard
from seamark.server.runs.record.states import RunKind, RunState
from seamark.server.runs.submission import baselines, quota, submission
from seamark.server.runs.submission.quota import QuotaExceeded
from seamark.server.runs.submission.validation import SubmissionRejected
from seamark.server.storage import installation
from seamark.sim import registry
from seamark.sim.settings.refusal import ConfigurationInvalid
from tests.cast import Backend
from tests.sandbox import host_compiler


def _worker(both: Backend, level: str, *languages: str, seen_at: float | None = None) -> None:
    now = time.time() if seen_at is None else seen_at
    worker = Worker(name=level, slots=1, level=level, languages=list(languages), findings=[])
    worker.started_at = worker.seen_at = now
    with both.database.writing() as session:
        session.add(worker)


def test_a_submission_is_completed_from_the_benchmark(backend: Backend) -> None:
    run_id = backend.queue("ann", config={"kp": 0.7})

    view = backend.show(run_id)
    assert view.config["kp"] == 0.7
    assert "level_duration_s" in view.config
    assert view.seed is not None


def test_a_wrong_configuration_is_refused_by_field(backend: Backend) -> None:
    with pytest.raises(ConfigurationInvalid) as refusal:
        backend.queue("ann", config={"kp": "much", "levels": []})

    assert set(refusal.value.errors) == {"kp", "levels"}


def test_a_ranked_run_gets_the_scenario_of_the_benchmark(backend: Backend) -> None:
    run_id = backend.queue("ann", config={"kp": 0.9}, kind=RunKind.RANKED)

    view = backend.show(run_id)
    assert len(view.config["levels"]) > 1
    assert view.config["kp"] == 0.9


def test_a_ranked_run_refuses_each_setting_that_differs_from_the_scenario(backend: Backend) -> None:
    changes = {"levels": [0.0], "level_duration_s": 120.0, "vehicle": "bluerov2-heavy", "kp": 0.9}

    with pytest.raises(ConfigurationInvalid) as refusal:
        backend.queue("ann", config=changes, kind=RunKind.RANKED)

    assert set(refusal.value.errors) == {"levels", "vehicle"}
    assert refusal.value.errors["levels"] == (
        "levels (Current levels) is fixed at 0, 0.1, 0.2, 0.3, 0.4 m/s in ranked runs. "
        "Leave it out, or start a practice run."
    )


def test_the_scenario_itself_may_be_sent_with_a_ranked_run(backend: Backend) -> None:
    first = backend.show(backend.queue("ann", kind=RunKind.RANKED))

    again = backend.queue("ann", config=first.config, trials=first.trials, kind=RunKind.RANKED)

    assert backend.show(again).config == first.config


@pytest.mark.parametrize(("field", "value"), [("seed", 7), ("trials", 1)])
def test_a_ranked_run_refuses_a_seed_and_a_number_of_trials(
    backend: Backend, field: str, value: int
) -> None:
    with pytest.raises(SubmissionRejected, match="practice run") as refusal:
        backend.queue("ann", kind=RunKind.RANKED, **{"seed": None, field: value})

    assert refusal.value.field == field


@pytest.mark.parametrize(
    "changes",
    [
        {"kind": RunKind.RANKED},
        {"benchmark": "none-v1"},
        {"controller": "none"},
        {"controller": "upload"},
        {"trials": 0},
        {"trials": 11},
        {"seed": -1},
        {"seed": 2**31},
    ],
)
def test_a_submission_that_breaks_a_rule_is_refused(
    backend: Backend, changes: dict[str, Any]
) -> None:
    with pytest.raises(SubmissionRejected):
        backend.queue("guest", **changes)


def test_a_guest_can_run_a_built_in_controller_but_not_an_upload(backend: Backend) -> None:
    assert backend.queue("guest")
    with pytest.raises(SubmissionRejected, match="account"):
        backend.queue("guest", controller="upload", program=backend.store_program())


def test_a_viewer_without_account_and_cookie_cannot_submit(backend: Backend) -> None:
    with pytest.raises(SubmissionRejected):
        backend.queue("nobody")


def test_the_quota_of_live_runs_is_enforced_and_freed_by_a_cancel(backend: Backend) -> None:
    made = [backend.queue("ann") for _ in range(backend.settings.quota_live)]

    with pytest.raises(QuotaExceeded, match="waiting or running"):
        backend.queue("ann")
    with backend.database.writing() as session:
        results.cancel(session, made[0])

    assert backend.queue("ann")


def test_only_completed_runs_count_for_the_daily_quota(both: Backend) -> None:
    done, broken, cancelled, old = (both.queue("ann") for _ in range(4))
    claim = both.claim()
    assert claim is not None
    both.finish(claim)
    with both.database.writing() as session:
        results.cancel(session, cancelled)
        for run_id, cause, age in ((broken, "platform_error", 0.0), (old, "user_error", 90_000.0)):
            change = update(Run).where(Run.id == run_id)
            values = {"state": "failed", "cause": cause, "finished_at": time.time() - age}
            session.execute(change.values(**values))
        used = quota.used_by(session, both.viewers["ann"], both.settings)

    assert claim.run_id == done
    assert (used.live, used.day) == (0, 1)


def test_uploads_are_refused_if_no_living_worker_can_isolate_them(backend: Backend) -> None:
    _worker(backend, "none", "python")
    _worker(backend, "strong", "python", seen_at=time.time() - 3600)

    with pytest.raises(SubmissionRejected, match="seamark doctor"):
        backend.queue("ann", controller="upload", program=backend.store_program())


def test_uploads_are_queued_while_there_is_no_worker(backend: Backend) -> None:
    assert backend.queue("ann", controller="upload", program=backend.store_program())


def test_a_language_that_no_worker_has_is_refused(backend: Backend) -> None:
    _worker(backend, "strong", "c")

    with pytest.raises(SubmissionRejected, match="programs in Python"):
        backend.queue("ann", controller="upload", program=backend.store_program())


def test_a_controller_that_cannot_get_images_is_refused_them_by_field(
    backend: Backend, tmp_path: Path
) -> None:
    program = backend.store_program(host_compiler.fmu("fmi2", tmp_path), "pi.fmu")
    run: dict[str, Any] = {"benchmark": "currents-v2", "controller": "upload", "program": program}

    with pytest.raises(SubmissionRejected, match="not in FMU") as refusal:
        backend.queue("ann", config={"images": "vehicle"}, **run)

    assert refusal.value.field == "images"
    assert backend.queue("ann", config={"images": "none"}, **run)


def test_a_rerun_is_a_new_run_of_the_same_submission(backend: Backend) -> None:
    old = backend.show(backend.queue("ann", config={"kp": 0.7}, seed=11, title="first"))

    with backend.database.writing() as session:
        new_id = submission.rerun(session, old.id, backend.viewers["ann"], backend.settings)

    new = backend.show(new_id)
    assert new.rerun_of == old.id
    assert (new.config, new.seed, new.title) == (old.config, 11, "first")


@pytest.mark.slow
def test_baselines_are_queued_once_claimed_last_and_published(backend: Backend) -> None:
    with backend.database.writing() as session:
        first = baselines.ensure(session, backend.settings)
        second = baselines.ensure(session, backend.settings)
    late = backend.queue("ann")

    order = []
    while (claim := backend.claim()) is not None:
        order.append(claim.run_id)
        backend.finish(claim, score=10.0)

    entries = [registry.benchmark(name).baselines for name in registry.BENCHMARKS]
    assert (len(first), second) == (sum(map(len, entries)), [])
    assert (order[0], sorted(order[1:])) == (late, first)
    with backend.database.reading() as session:
        ranks = leaderboard.page(session, "currents-v1")
    assert {rank.user: rank.is_baseline for rank in ranks} == {
        "seamark-p": True,
        "seamark-pi": True,
    }
    assert backend.show(first[0]).public
    assert backend.show(late).state is RunState.SUCCEEDED


@pytest.mark.parametrize("kind", RunKind)
@pytest.mark.parametrize("name", registry.REFERENCE_CONTROLLERS)
def test_nobody_can_submit_a_reference_entry(backend: Backend, name: str, kind: RunKind) -> None:
    with pytest.raises(SubmissionRejected, match="is a reference entry: the service runs it"):
        backend.queue("ann", controller=name, kind=kind)


def test_only_one_baseline_runs_at_a_time(both: Backend) -> None:
    with both.database.writing() as session:
        baselines.ensure(session, both.settings)

    claims = [both.claim("w1"), both.claim("w2")]

    assert [claim is None for claim in claims] == [False, True]


def test_a_missing_language_is_refused_with_the_reason_of_the_worker(both: Backend) -> None:
    _worker(both, "strong", "python")
    found = {
        "name": workers.finding_of("matlab"),
        "ok": False,
        "why": "octave is not installed.",
    }
    with both.database.writing() as session:
        worker = session.get_one(Worker, "strong")
        worker.findings = [found]

    with both.database.reading() as session:
        refusals = {
            name: workers.upload_refusal(session, name, both.settings) for name in LANGUAGES
        }

    assert refusals["python"] is None
    assert refusals["matlab"] == (
        "No worker of this service can run programs in MATLAB (by GNU Octave): "
        "octave is not installed."
    )
    assert refusals["c++"] == "No worker of this service can run programs in C++."


def test_uploads_wait_while_what_they_need_is_being_installed(both: Backend) -> None:
    _worker(both, "strong", "python")

    with installation.announced(both.settings), both.database.reading() as session:
        refusals = [workers.upload_refusal(session, each, both.settings) for each in LANGUAGES]
        waiting = [
            each
            for each in ("python", "matlab")
            if workers.waits_for_installation(session, each, both.settings)
        ]
    with both.database.reading() as session:
        refused_then = workers.upload_refusal(session, "matlab", both.settings)
        waits_then = workers.waits_for_installation(session, "matlab", both.settings)

    assert refusals == [None] * len(LANGUAGES)
    assert waiting == ["matlab"]
    assert refused_then is not None
    assert not waits_then


def test_a_run_in_a_language_of_an_earlier_version_is_readable_but_cannot_be_submitted(
    both: Backend,
) -> None:
    _worker(both, "strong", "python")
    run_id = both.queue_program("ann")
    with both.database.writing() as session:
        session.get_one(Run, run_id).language = "cobol"

    assert "programs in cobol" in (both.show(run_id).why_waiting or "")
    with (
        pytest.raises(SubmissionRejected, match="not in cobol"),
        both.database.writing() as session,
    ):
        submission.rerun(session, run_id, both.viewers["ann"], both.settings)
