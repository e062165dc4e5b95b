"""What admins decide, with real workers: computing runs again, draining."""

import pytest
from sqlalchemy import select, update

from seamark.server.accounts.audit import Actor
from seamark.server.administration import rejudgements, worker_list
from seamark.server.administration.rejudge_choice import RunChoice
from seamark.server.administration.rejudgements import Difference, RejudgementView
from seamark.server.database.tables import Result, Run
from seamark.server.messaging import broker
from seamark.server.runs.record.states import RunState
from tests.worker.conftest import LONG, P, Service, wait_until

pytestmark = [pytest.mark.host, pytest.mark.slow]

ROOT = Actor("root")


def _rejudged(service: Service) -> tuple[RejudgementView, list[Difference]]:
    """Compute all runs again; return what came of it, before any decision."""
    with service.database.writing() as session:
        choice = RunChoice(benchmark="currents-v1")
        number = rejudgements.start(session, ROOT, choice, "To be sure", service.settings)
    broker.send_tickets(service.app)

    def shown() -> RejudgementView:
        with service.database.reading() as session:
            found = rejudgements.show(session, number)
        assert found is not None
        return found

    wait_until(lambda: not shown().progress.live)
    with service.database.reading() as session:
        return shown(), list(rejudgements.all_differences(session, shown().row))


def test_an_unchanged_platform_gives_the_same_results_and_finds_one_that_was_tampered_with(
    running: Service, isolation: object
) -> None:
    program, built_in = running.submit_program(P), running.submit()
    for run_id in (program, built_in):
        assert running.ended(run_id).state is RunState.SUCCEEDED

    first, none = _rejudged(running)
    assert (first.progress.same, first.progress.failed, none) == (2, 0, [])
    with running.database.writing() as session:
        rejudgements.accept(session, ROOT, first.row.id)
        session.execute(update(Result).where(Result.run_id == program).values(score=99.0))
    _, [found] = _rejudged(running)

    assert (found.run_id, found.before["score"]) == (program, 99.0)
    assert found.before["digest"] == found.after["digest"]


def _worker_of(service: Service, run_id: int) -> str:
    """Return the name of the worker that has or had a run."""
    with service.database.reading() as session:
        process = session.scalars(select(Run.worker).where(Run.id == run_id)).one()
    return (process or "").rpartition("/")[0]


def test_a_drained_worker_ends_its_run_and_another_one_takes_over_until_it_is_resumed(
    running: Service,
) -> None:
    long = running.submit(LONG)
    running.wait(long, lambda view: view.state is RunState.RUNNING)
    drained = _worker_of(running, long)
    with running.database.writing() as session:
        assert worker_list.drain(session, ROOT, drained)
    waiting = running.submit(who="ben")
    assert running.ended(long).attempt == 1
    assert running.show(waiting).state is RunState.QUEUED

    running.start_worker()
    running.ended(waiting)
    other = _worker_of(running, waiting)
    with running.database.writing() as session:
        assert worker_list.drain(session, ROOT, other)
        assert worker_list.resume(session, ROOT, drained)
    again = running.submit(who="ben")
    running.ended(again)

    assert _worker_of(running, long) == _worker_of(running, again) == drained != other
