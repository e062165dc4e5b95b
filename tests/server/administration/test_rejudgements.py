"""Computing a set of runs again: what is chosen, who notices, what changes and what is kept."""

from typing import Any

import pytest
from sqlalchemy import select, update

from seamark.server.accounts import audit
from seamark.server.accounts.audit import Actor, AuditFilter
from seamark.server.accounts.permissions import Viewer
from seamark.server.administration import rejudge_choice, rejudgements
from seamark.server.administration.rejudge_choice import Chosen, RunChoice
from seamark.server.administration.rejudgements import Difference, RejudgementRefused
from seamark.server.database.tables import Result, Run
from seamark.server.runs.ending import deletion
from seamark.server.runs.leaderboard import best_runs, leaderboard
from seamark.server.runs.leaderboard.rank_preview import RankChange
from seamark.server.runs.queue.queue import Claim
from seamark.server.runs.recomputation import rejudged
from seamark.server.runs.record import totals
from seamark.server.runs.record.states import RunState
from seamark.server.runs.showing import run_lists
from seamark.server.runs.showing.run_lists import RunFilter
from seamark.server.runs.submission import quota
from seamark.sim.recording.manifest import code_sha256
from tests.cast import Backend

ROOT = Actor("root", "192.0.2.1")
V1 = "currents-v1"


def _choose(backend: Backend, **fields: Any) -> Chosen:
    with backend.database.reading() as session:
        return rejudge_choice.choose(session, RunChoice(**{"benchmark": V1} | fields))


def _start(backend: Backend, **fields: Any) -> int:
    choice = RunChoice(**{"benchmark": V1} | fields)
    with backend.database.writing() as session:
        return rejudgements.start(session, ROOT, choice, "A bug in the drag", backend.settings)


def _accept(backend: Backend, number: int) -> None:
    with backend.database.writing() as session:
        rejudgements.accept(session, ROOT, number)


def _discard(backend: Backend, number: int) -> None:
    with backend.database.writing() as session:
        rejudgements.discard(session, ROOT, number)


def _different(backend: Backend, number: int) -> list[Difference]:
    with backend.database.reading() as session:
        view = rejudgements.show(session, number)
        assert view is not None
        return list(rejudgements.all_differences(session, view.row))


def _progress(backend: Backend, number: int) -> tuple[int, int, int, int]:
    with backend.database.reading() as session:
        view = rejudgements.show(session, number)
    assert view is not None
    found = view.progress
    return found.live, found.same, found.different, found.failed


def _original(backend: Backend, claim: Claim) -> int | None:
    with backend.database.reading() as session:
        return session.get_one(Run, claim.run_id).rejudges


def _rank(backend: Backend, who: str) -> int | None:
    with backend.database.reading() as session:
        found = leaderboard.rank_of(session, V1, backend.user_id(who))
    return None if found is None else found.rank


def _ranked(backend: Backend, who: str, score: float) -> int:
    claim = backend.running(who, kind="ranked")
    assert backend.finish(claim, score)
    return backend.publish(claim.run_id)


def test_a_run_is_computed_again_with_what_its_result_depends_on(backend: Backend) -> None:
    run_id = backend.queue_program("ann", kind="ranked")
    first = backend.claim_next()
    backend.finish(first)

    _start(backend)
    again = backend.claim_next()

    assert _original(backend, again) == run_id
    differ = {"run_id", "attempt", "user_id"}
    assert again.model_dump(exclude=differ) == first.model_dump(exclude=differ)


def test_the_same_result_is_no_difference_and_nothing_changes(backend: Backend) -> None:
    run_id = backend.succeeded("ann")
    before, number = backend.show(run_id), _start(backend)

    backend.finish(backend.claim_next())
    assert (_progress(backend, number), _different(backend, number)) == ((0, 1, 0, 0), [])
    _accept(backend, number)

    assert backend.show(run_id) == before


def test_a_result_that_was_tampered_with_is_found_and_replaced(both: Backend) -> None:
    run_id = _ranked(both, "ann", 50.0)
    _ranked(both, "ben", 60.0)
    with both.database.writing() as session:
        session.execute(update(Result).where(Result.run_id == run_id).values(score=70.0))
        best_runs.refresh(session, V1, both.user_id("ann"))
    assert (_rank(both, "ann"), _rank(both, "ben")) == (1, 2)

    number = _start(both)
    for score in (50.0, 60.0):
        both.finish(both.claim_next(), score)
    [found] = _different(both, number)
    assert (found.run_id, found.user, found.rank) == (run_id, "ann", RankChange(1, 2))
    assert (found.before["score"], found.after["score"], found.metrics_count) == (70.0, 50.0, 0)
    _accept(both, number)

    assert (_rank(both, "ann"), _rank(both, "ben")) == (2, 1)
    with both.database.reading() as session:
        [kept] = rejudged.history(session, run_id)
    assert kept.earlier is not None
    assert (kept.earlier["score"], kept.reason) == (70.0, "A bug in the drag")


def test_metrics_state_and_digest_that_differ_are_named(backend: Backend) -> None:
    ended, failed = backend.succeeded("ann"), backend.failed({}, "ben")
    number = _start(backend)

    backend.finish(backend.claim_next(), 51.0, digest="1" * 64)
    backend.finish(backend.claim_next())

    one, two = _different(backend, number)
    assert (one.run_id, two.run_id) == (ended, failed)
    assert one.before["digest"] != one.after["digest"]
    assert "trials[2].score" in one.metrics
    assert (two.before["state"], two.before["cause"]) == ("failed", "user_error")
    assert (two.after["state"], two.after["cause"]) == ("succeeded", None)
    _accept(backend, number)
    shown = backend.show(failed)
    assert (shown.state, shown.cause, shown.score) == (RunState.SUCCEEDED, None, 50.0)


def test_the_preview_counts_all_replaced_results_at_once(backend: Backend) -> None:
    for who, score in (("ann", 50.0), ("eva", 40.0), ("ben", 30.0)):
        _ranked(backend, who, score)
    number = _start(backend)

    for score in (20.0, 25.0, 30.0):
        backend.finish(backend.claim_next(), score)

    previewed = {each.user: each.rank for each in _different(backend, number)}
    assert previewed == {"ann": RankChange(1, 3), "eva": RankChange(2, 2)}
    _accept(backend, number)
    assert [_rank(backend, who) for who in ("ann", "eva", "ben")] == [3, 2, 1]


def test_users_do_not_notice_runs_that_are_computed_again(backend: Backend) -> None:
    backend.succeeded("ann")
    root = backend.viewers["root"]

    def noticed() -> tuple[object, ...]:
        with backend.database.reading() as session:
            listed = run_lists.page(session, root, RunFilter(which="all"))
            used = quota.used_by(session, Viewer(user_id=backend.user_id("ann")), backend.settings)
            return [run.id for run in listed.runs], totals.counts(session), used

    before = noticed()
    _start(backend)
    queued = noticed()
    backend.claim_next()

    assert [queued, noticed()] == [before, before]


@pytest.mark.slow
def test_runs_of_users_and_guests_start_first(backend: Backend) -> None:
    old = backend.succeeded("ann")
    _start(backend)
    waiting = [backend.queue("guest"), backend.queue("ben")]

    claims = [backend.claim_next() for _ in range(3)]

    assert {claim.run_id for claim in claims[:2]} == set(waiting)
    assert _original(backend, claims[2]) == old


def test_a_rejudgement_is_discarded_at_any_time_and_changes_nothing(both: Backend) -> None:
    first, second = both.succeeded("ann"), both.succeeded("ben")
    before, number = (both.show(first), both.show(second)), _start(both)
    both.finish(both.claim_next(), 99.0)
    running = both.claim_next()

    with pytest.raises(RejudgementRefused, match="Wait until all runs"):
        _accept(both, number)
    _discard(both, number)

    assert both.finish(running) is False
    assert both.claim() is None
    assert (both.show(first), both.show(second)) == before
    with pytest.raises(RejudgementRefused, match="has already been discarded"):
        _accept(both, number)


def test_only_one_rejudgement_waits_for_its_decision(backend: Backend) -> None:
    backend.succeeded("ann")
    number = _start(backend)

    with pytest.raises(RejudgementRefused, match=f"rejudgement {number} first"):
        _start(backend)


def test_a_failure_of_the_service_is_no_outcome_and_replaces_nothing(backend: Backend) -> None:
    run_id = backend.succeeded("ann")
    number = _start(backend)

    backend.finish(backend.claim_next(), state=RunState.FAILED, cause="platform_error")
    assert _progress(backend, number) == (0, 0, 0, 1)
    _accept(backend, number)

    assert backend.show(run_id).state is RunState.SUCCEEDED


def test_runs_are_chosen_by_all_that_computed_them(both: Backend) -> None:
    def ended(who: str, worker: str, code: str, **changes: Any) -> int:
        run_id = both.queue_program(who) if changes else both.queue(who)
        claim = both.claim(worker)
        assert claim is not None
        versions = {"seamark": "1.0" if code == "old" else "2.0"}
        now = {"code_sha256": code_sha256() if code == "new" else code, "versions": versions}
        both.finish(claim, manifest=now)
        return run_id

    one = ended("ann", "w1@host/0", "old")
    two = ended("ben", "w10@host/0", "new", upload=True)
    both.cancel(both.queue("ann"))

    assert list(_choose(both).runs) == [two, one]
    assert list(_choose(both, other_code=True).runs) == [one]
    assert list(_choose(both, version="2.0").runs) == [two]
    assert list(_choose(both, worker="w1@host").runs) == [one]
    assert list(_choose(both, language="python").runs) == [two]
    assert list(_choose(both, language="built-in").runs) == [one]
    assert list(_choose(both, kind="ranked").runs) == []
    assert list(_choose(both, benchmark="currents-v2").runs) == []
    at = both.show(two).finished_at
    assert list(_choose(both, ended_from=at).runs) == [two]
    assert list(_choose(both, ended_to=at).runs) == [one]


def test_what_a_deleted_run_left_in_a_rejudgement_is_deleted(both: Backend) -> None:
    run_id = both.succeeded("ann")
    number = _start(both)
    both.finish(both.claim_next(), 99.0)
    _accept(both, number)

    with both.database.writing() as session:
        assert deletion.empty(session, [run_id]) == [run_id]
        hidden = session.scalars(select(Run).where(Run.rejudges == run_id)).one()
        left = (hidden.config, session.get_one(Result, hidden.id).metrics)
        [kept] = rejudged.history(session, run_id)

    assert (left, kept.earlier) == (({}, None), None)


def test_every_decision_has_an_entry_in_the_audit_log(backend: Backend) -> None:
    backend.succeeded("ann")
    _discard(backend, _start(backend))
    number = _start(backend)
    backend.finish(backend.claim_next(), 99.0)
    _accept(backend, number)

    with backend.database.reading() as session:
        entries = audit.page(session, AuditFilter(target=f"rejudgement {number}")).entries
    assert [(each.actor, each.action) for each in entries] == [
        ("root", "rejudgement_accepted"),
        ("root", "rejudgement_started"),
    ]
    assert entries[0].detail == {"replaced": 1, "same": 0, "failed": 0}
