"""Deleting runs: what goes, what stays, and what deleting must not evade."""

import numpy as np
import pytest
from sqlalchemy import select

from seamark.server.database.tables import Result, Run
from seamark.server.runs.data import retention
from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.ending import deletion
from seamark.server.runs.leaderboard import best_runs, leaderboard, score_counts
from seamark.server.runs.publication import publications
from seamark.server.runs.showing import views
from seamark.server.runs.submission import quota
from seamark.server.runs.submission.quota import QuotaExceeded
from seamark.sim.recording.telemetry import WIDTH
from tests.cast import Backend


def _delete(backend: Backend, *run_ids: int) -> list[int]:
    return deletion.delete(backend.database, backend.settings, run_ids)


def test_a_deleted_run_is_gone_with_its_files_its_texts_and_its_score(backend: Backend) -> None:
    run_id = backend.succeeded("ann", title="secret", notes="secret", config={"kp": 0.123})
    RunFiles(backend.settings.data, run_id, 1).append_rows(np.zeros((3, WIDTH)))

    assert _delete(backend, run_id) == [run_id]

    with backend.database.reading() as session:
        shown = views.show(session, run_id)
        run, result = session.get_one(Run, run_id), session.get_one(Result, run_id)
        left = (run.title, run.notes, run.config, run.data_bytes, result.score, result.metrics)
    assert shown is None
    assert left == ("", "", {}, 0, None, None)
    assert not RunFiles(backend.settings.data, run_id).root.exists()


def test_only_private_runs_that_have_ended_are_deleted_and_only_once(backend: Backend) -> None:
    public, private = backend.published("ann"), backend.succeeded("ann")
    running = backend.running("ann").run_id
    queued = backend.queue("ann")

    assert _delete(backend, public, private, running, queued) == [private]
    assert _delete(backend, private) == []


def test_deleting_runs_gives_back_neither_ranked_submissions_nor_quota(backend: Backend) -> None:
    settings = backend.settings.model_copy(update={"ranked_day": 1, "quota_day": 1})
    ranked = backend.succeeded("ann", kind="ranked")

    _delete(backend, ranked)

    with backend.database.reading() as session:
        ann = backend.viewers["ann"]
        with pytest.raises(QuotaExceeded):
            quota.enforce_ranked(session, ann, "currents-v1", settings)
        with pytest.raises(QuotaExceeded):
            quota.enforce(session, ann, settings, new_bytes=0)


def test_after_the_deletion_of_the_best_run_the_next_one_ranks(backend: Backend) -> None:
    entry = backend.published("ann", kind="ranked")
    claim = backend.running("ann", kind="ranked")
    assert backend.finish(claim, score=90.0)
    backend.publish(claim.run_id)
    with backend.database.writing() as session:
        assert publications.withdraw(session, claim.run_id)

    _delete(backend, claim.run_id)

    with backend.database.writing() as session:
        (kept,) = leaderboard.page(session, "currents-v1")
        assert score_counts.size(session, "currents-v1") == 1
        best_runs.rebuild(session)
        assert leaderboard.page(session, "currents-v1") == [kept]
        assert score_counts.size(session, "currents-v1") == 1
    assert (kept.run_id, kept.rank, kept.submissions) == (entry, 1, 2)


def test_a_number_is_not_given_to_a_second_run(backend: Backend) -> None:
    run_id = backend.succeeded("ann")
    _delete(backend, run_id)

    assert backend.queue("ann") > run_id


def test_the_files_of_a_deleted_run_that_were_left_behind_are_swept(backend: Backend) -> None:
    run_id = backend.succeeded("ann")
    _delete(backend, run_id)
    RunFiles(backend.settings.data, run_id, 1).append_rows(np.zeros((3, WIDTH)))

    retention.Sweep(backend.database, backend.settings).step()

    assert not RunFiles(backend.settings.data, run_id).root.exists()


def test_the_rows_of_deleted_runs_keep_who_submitted_them_and_when(backend: Backend) -> None:
    run_id = backend.succeeded("ann")
    with backend.database.reading() as session:
        before = session.execute(select(Run.owner, Run.queued_at, Run.state)).one()
    _delete(backend, run_id)

    with backend.database.reading() as session:
        assert session.execute(select(Run.owner, Run.queued_at, Run.state)).one() == before
