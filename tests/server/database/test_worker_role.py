"""What a worker may do with a role of its own, and what it may not even read."""

import json
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import pytest
from click.testing import CliRunner
from sqlalchemy import inspect, select, text
from sqlalchemy.exc import ProgrammingError

from seamark.cli.main import cli
from seamark.server.database import worker_role
from seamark.server.database.engine import Database
from seamark.server.database.mail_tables import RunNotice
from seamark.server.database.schema import check_all
from seamark.server.database.tables import Best, Worker
from seamark.server.messaging import workers
from seamark.server.programs import check_queue, store
from seamark.server.runs.data import disk_usage, retention
from seamark.server.runs.data.retention import Sweep
from seamark.server.runs.leaderboard import best_runs
from seamark.server.runs.queue import lost_attempts
from seamark.server.runs.queue import queue as run_queue
from seamark.server.runs.queue.lost_attempts import AttemptEnd
from seamark.server.runs.queue.queue import LeaseStatus
from seamark.server.runs.record.states import RunState
from seamark.server.settings import Settings
from tests.cast import Backend
from tests.services import tables

ROLE = "seamark_worker"
WITHHELD = {
    *("account_deletions", "audit_entries", "browser_sessions", "invitations", "password_resets"),
    *(
        "linked_identities",
        "mail_addresses",
        "outgoing_mails",
        "submission_keys",
        "tokens",
        "users",
    ),
    *("final_places", "method_texts", "round_changes", "team_members", "teams"),
}
REFUSED = (
    "SELECT password_hash FROM users",
    "SELECT * FROM users",
    "SELECT hash FROM browser_sessions",
    "SELECT hash FROM tokens",
    "SELECT hash FROM invitations",
    "SELECT * FROM password_resets",
    "SELECT * FROM mail_addresses",
    "SELECT * FROM run_notices",
    "SELECT * FROM audit_entries",
    "DELETE FROM audit_entries",
    "UPDATE users SET role = 'admin'",
    "INSERT INTO tokens (user_id) VALUES (1)",
    "DELETE FROM runs",
    "UPDATE data_folder SET result_code = ''",
    "CREATE TABLE mine (id int)",
)


@pytest.fixture
def service(settings: Settings, postgres_tables_url: str) -> Iterator[Backend]:
    """The cast on PostgreSQL, with a role for workers."""
    settings = settings.model_copy(update={"database_url": postgres_tables_url})
    database = tables.adopt(settings)
    with database.engine.begin() as connection:
        connection.execute(text(f"DROP ROLE IF EXISTS {ROLE}"))
        connection.execute(text(f"CREATE ROLE {ROLE} LOGIN"))
    answer = CliRunner().invoke(
        cli, ["db", "grant-worker", ROLE, "--json"], env=settings.environment()
    )
    assert json.loads(answer.output) == {"role": ROLE}
    yield Backend.with_cast(database, settings)
    with database.engine.begin() as connection:
        connection.execute(text(f"DROP OWNED BY {ROLE}"))
        connection.execute(text(f"DROP ROLE {ROLE}"))
    database.close()


@pytest.fixture
def worker(service: Backend) -> Iterator[Backend]:
    """The same service as a worker reaches it."""
    url = service.settings.database_url.replace("//postgres@", f"//{ROLE}@")
    settings = service.settings.model_copy(update={"database_url": url})
    made = replace(service, database=Database(url), settings=settings)
    yield made
    made.database.close()


def test_a_worker_does_all_of_its_work_with_its_own_role(service: Backend, worker: Backend) -> None:
    check_all(worker.settings, computes=True)
    listed: dict[str, Any] = {"languages": ["python"], "findings": [], "contents": {}}
    with worker.database.writing() as session:
        workers.register(session, Worker(name="w1", slots=2, level="strong", version="1", **listed))
        workers.heartbeat(session, "w1", {})
    first, second, third = (service.queue(who) for who in ("ann", "eva", "ben"))
    program, ann = service.store_program(), service.user_id("ann")
    with service.database.writing() as session:
        check_queue.enqueue(session, ann, "currents-v1", {}, program)

    succeeded = worker.claim_next()
    with worker.database.writing() as session:
        held = run_queue.heartbeat(
            session, succeeded, progress=0.5, t_simulated=1.0, isolation=None
        )
    assert worker.finish(succeeded)
    released = worker.claim_next()
    with worker.database.writing() as session:
        state = lost_attempts.release(
            session, released, AttemptEnd.SHUTDOWN, settings=worker.settings
        )
        check = check_queue.claim(session, "w1/checks", languages=("python",), lease_s=30.0)
        assert check is not None
        assert check_queue.renew(session, check)
        assert check_queue.finish(session, check, {"ok": True})
        check_queue.recover(session, {})
    lost = worker.claim_next()
    with worker.database.reading() as session:
        leases = lost_attempts.leases(session)
    with worker.database.writing() as session:
        recovery = lost_attempts.recover(session, leases, worker.settings)
        lost_attempts.tidy(session)
        best_runs.complete(session)
    Sweep(worker.database, worker.settings).step()
    retention.delete(worker.database, worker.settings, [succeeded.run_id])
    disk_usage.measure_if_old(worker.database, worker.settings)
    store.delete_unused(worker.settings, used=lambda _: True)
    with worker.database.writing() as session:
        workers.unregister(session, "w1")

    assert {succeeded.run_id, released.run_id, lost.run_id} <= {first, second, third}
    assert held is LeaseStatus.HELD
    assert state is RunState.QUEUED
    assert recovery.requeued == [lost.run_id]


def test_a_baseline_is_published_by_its_worker(service: Backend, worker: Backend) -> None:
    with service.database.writing() as session:
        session.execute(text("UPDATE users SET is_baseline = true WHERE name = 'eva'"))
    run_id = service.queue_program("eva", kind="ranked", title="Steady hand")

    assert worker.finish(worker.claim_next())

    with service.database.reading() as session:
        assert session.scalars(select(Best.run_id)).all() == [run_id]


def test_a_worker_is_refused_what_it_does_not_need(worker: Backend) -> None:
    for statement in REFUSED:
        with (
            pytest.raises(ProgrammingError, match="permission denied"),
            worker.database.writing() as session,
        ):
            session.execute(text(statement))


def test_of_every_table_it_is_known_whether_workers_have_rights_on_it(service: Backend) -> None:
    granted = {*worker_role.READ, *worker_role.CHANGED, *worker_role.OWN, *worker_role.ADDED}

    with service.database.engine.connect() as connection:
        assert {*inspect(connection).get_table_names()} == granted | WITHHELD


def test_a_worker_notes_that_a_run_has_ended_without_reading_whom_to_tell(
    service: Backend, worker: Backend
) -> None:
    with service.database.writing() as session:
        session.execute(text("UPDATE users SET notify_minutes = 0 WHERE name = 'ann'"))
    run_id = service.queue("ann")

    assert worker.finish(worker.claim_next())

    with service.database.reading() as session:
        assert session.scalars(select(RunNotice.run_id)).all() == [run_id]


def test_a_worker_leaves_to_others_what_its_role_may_not_do(
    service: Backend, worker: Backend
) -> None:
    restricted = []
    for backend in (service, worker):
        with backend.database.engine.connect() as connection:
            restricted.append(worker_role.is_restricted(connection))

    assert restricted == [False, True]


def test_sqlite_has_no_role_for_workers(database: Database) -> None:
    with (
        database.engine.connect() as connection,
        pytest.raises(worker_role.NotPostgreSQL, match="share a file"),
    ):
        worker_role.grant(connection, ROLE)
