"""Every schema from the first one on can be upgraded, also by several processes at once."""

import multiprocessing
from itertools import pairwise
from multiprocessing.synchronize import Barrier
from pathlib import Path
from typing import Any

import pytest
from alembic import command
from alembic.script import ScriptDirectory
from sqlalchemy import Connection, MetaData, inspect, select, update

from performance.service.database.requests import create_first
from seamark.server.accounts import accounts, audit, browser_sessions, invitations
from seamark.server.accounts.audit import Actor, AuditAction
from seamark.server.classes import classrooms
from seamark.server.database.account_tables import AccountDeletion, LinkedIdentity, PasswordReset
from seamark.server.database.class_tables import AssignedRun, Classroom
from seamark.server.database.competition_tables import (
    Competition,
    CompetitionFile,
    Entry,
    FinalPlace,
    MethodText,
    RoundChange,
)
from seamark.server.database.engine import Database
from seamark.server.database.mail_tables import MailAddress, OutgoingMail, RunNotice
from seamark.server.database.operation_tables import DiskUsage
from seamark.server.database.publication_tables import Verification
from seamark.server.database.queue_tables import Counter
from seamark.server.database.rejudgement_tables import RejudgedRun
from seamark.server.database.schema import check, config, upgrade
from seamark.server.database.submission_tables import KeyOfSubmission, SeenSubmission
from seamark.server.database.tables import RunFile, RunPart, Worker
from seamark.server.messaging import workers
from seamark.server.programs import check_queue
from seamark.server.settings import Settings
from tests.cast import Backend
from tests.server.judging.cup import Cup

ROOT = Path(__file__).parents[3]
PROCESSES = 3
START_S = 120.0  # until all processes are there on a busy machine
Rows = dict[str, list[dict[str, Any]]]


@pytest.fixture(
    params=["database_url", pytest.param("postgres_url", marks=pytest.mark.host)],
    ids=["sqlite", "postgresql"],
)
def empty(request: pytest.FixtureRequest, settings: Settings) -> Settings:
    """Settings of a database of each type in turn, without tables."""
    url = request.getfixturevalue(request.param)
    return settings.model_copy(update={"database_url": url})


def _upgrade_together(settings: Settings, start: Barrier) -> None:
    start.wait(START_S)
    upgrade(settings)


@pytest.mark.slow
def test_processes_that_upgrade_at_the_same_time_all_succeed(empty: Settings) -> None:
    fork = multiprocessing.get_context("fork")  # others would import the service first
    start = fork.Barrier(PROCESSES)
    processes = [
        fork.Process(target=_upgrade_together, args=(empty, start)) for _ in range(PROCESSES)
    ]

    for process in processes:
        process.start()
    for process in processes:
        process.join(2 * START_S)

    assert [process.exitcode for process in processes] == [0] * PROCESSES
    database = Database(empty.database_url)
    check(database.engine)
    database.close()


def _revisions() -> list[str]:
    """Return all revisions, newest first."""
    return [script.revision for script in ScriptDirectory.from_config(config()).walk_revisions()]


def _fill(backend: Backend) -> None:
    """Write at least one row into each table."""
    backend.published("ann", kind="ranked")
    backend.failed({}, "ben")
    backend.queue("guest")
    program, ann = backend.store_program(), backend.user_id("ann")
    with backend.database.writing() as session:
        accounts.new_token(session, ann, "t", ["read"])
        browser_sessions.begin(session, ann)
        invitations.create(session, days=1.0, user_id=ann)
        check_queue.enqueue(session, ann, "currents-v1", {}, program)
        worker = Worker(name="w", slots=1, level="strong", languages=[], findings=[])
        workers.register(session, worker)
        create_first(session, ann)
        code = session.scalars(select(Classroom.code)).one()
        classrooms.join(session, backend.user_id("ben"), code)
        session.add(AssignedRun(run_id=1, assignment_id=1, user_id=ann, score=None))
        audit.record(session, Actor("ann"), AuditAction.ACCOUNT_DISABLED, "ben")
        first = {"number": 1, "created_at": 0.0}
        session.add(KeyOfSubmission(user_id=ann, key="k", request="r", **first))
        session.add(SeenSubmission(submission="s", run_id=1, digest="d", seen_at=1.0))
        session.add(PasswordReset(hash="h", user_id=ann, expires_at=1.0))
        part = {"role": "tracker", "program_sha256": "0" * 64, "program_name": "mine.c"}
        session.add(RunPart(run_id=1, language="c", **part))
        session.add(RunFile(run_id=1, setting="current_record", sha256="0" * 64))
        session.add(RejudgedRun(run_id=2, rejudgement_id=1))
        session.add(Verification(again_id=2, run_id=1, requested_at=1.0))
        session.add(Counter(name="simulated_s", value=1.0))
        session.add(DiskUsage(kind="area", name="runs", bytes=1, count=1))
        session.add(MailAddress(user_id=ann, address="ann@example.org", address_hash="a"))
        times = {"created_at": 0.0, "next_try_at": 0.0}
        session.add(OutgoingMail(kind="reset", user_id=ann, address_hash="a", **times))
        session.add(RunNotice(user_id=ann, run_id=1))
        identity = {"issuer": "https://id.example.org", "subject": "1", "label": "Ann"}
        session.add(LinkedIdentity(user_id=ann, linked_at=1.0, **identity))
        session.add(AccountDeletion(user_id=backend.user_id("eva"), requested_at=1.0))
    _fill_competition(backend)


def _fill_competition(backend: Backend) -> None:
    cup = Cup.draft(backend)
    with backend.database.writing() as session:
        session.execute(update(Competition).values(opened_at=1.0, picture=b"png"))
    team, numbers = cup.team("ben"), {"round_id": cup.view.rounds[0].id, "run_id": 1}
    of_team = {"team_id": team, "method": "PI"}
    with backend.database.writing() as session:
        session.add(Entry(method_key="pi", submitted_at=1.0, **numbers, **of_team))
        file = {"setting": "current_record", "sha256": "0" * 64}
        session.add(CompetitionFile(competition_id=cup.id, **file))
        session.add(MethodText(team_id=team, method_key="pi", text="A PI."))
        session.add(FinalPlace(trials=1, **numbers, **of_team))
        changed = {"at": 1.0, "before": 2.0, "after": 3.0, "reason": "The service was down."}
        session.add(RoundChange(round_id=numbers["round_id"], **changed))


def _rows(connection: Connection) -> Rows:
    """Return the content of all tables as the present schema has them, in a fixed order."""
    tables = MetaData()
    tables.reflect(connection)
    return {
        table.name: [
            dict(row._mapping)
            for row in connection.execute(select(table).order_by(*table.primary_key.columns))
        ]
        for table in tables.sorted_tables
        if table.name != "alembic_version"
    }


def _shared(rows: Rows, other: Rows) -> Rows:
    """Return the tables and columns of `rows` that `other` has too."""
    return {
        name: [{key: row[key] for key in row if key in other[name][0]} for row in rows[name]]
        for name in rows.keys() & other.keys()
    }


@pytest.mark.slow
def test_data_survive_the_way_to_every_earlier_schema_and_back(both: Backend) -> None:
    _fill(both)
    with both.database.engine.begin() as connection:
        latest = _rows(connection)
    assert [name for name, rows in latest.items() if not rows] == []  # new table? then `_fill` it

    for revision in _revisions():
        with both.database.engine.begin() as connection:
            command.downgrade(config(connection), revision)
            earlier = _rows(connection)
            command.upgrade(config(connection), "head")
            again = _rows(connection)

        assert _shared(earlier, latest) == _shared(latest, earlier)
        assert _shared(again, earlier) == _shared(earlier, again)
        assert {name: len(rows) for name, rows in again.items() if name in earlier} == {
            name: len(rows) for name, rows in earlier.items()
        }


def _schema(connection: Connection) -> dict[str, Any]:
    """Return what an earlier version can tell of the schema: columns, keys, indexes, rules."""
    found = inspect(connection)
    return {
        table: {
            "columns": {
                column["name"]: (str(column["type"]), column["nullable"])
                for column in found.get_columns(table)
            },
            # Columns that an INSERT has to name.
            "required": {
                column["name"]
                for column in found.get_columns(table)
                if not column["nullable"] and column["default"] is None
            },
            "indexes": {
                index["name"]: (index["column_names"], index["unique"])
                for index in found.get_indexes(table)
            },
            "foreign keys": {key["name"] for key in found.get_foreign_keys(table)},
            "rules": {rule["name"] for rule in found.get_check_constraints(table)},
            "unique": {key["name"] for key in found.get_unique_constraints(table)},
        }
        for table in found.get_table_names()
    }


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:Skipped unsupported reflection of expression-based index")
def test_a_downgrade_leads_to_the_schema_that_the_earlier_version_made(empty: Settings) -> None:
    database, made, left = Database(empty.database_url), {}, {}
    with database.engine.begin() as connection:
        for revision in reversed(_revisions()):
            command.upgrade(config(connection), revision)
            made[revision] = _schema(connection)
        for revision in _revisions():
            command.downgrade(config(connection), revision)
            left[revision] = _schema(connection)
    database.close()

    for schema in (*left.values(), *made.values()):
        for table in schema.values():
            table.pop("required")  # what a downgrade restores has defaults, for the rows that exist
    assert left == made


def _takes_from(before: dict[str, Any], after: dict[str, Any]) -> bool:
    """Return whether a process that knows the schema `before` may fail on `after`."""
    for table, old in before.items():
        new = after.get(table)
        if new is None or not old["columns"].items() <= new["columns"].items():
            return True
        if new["rules"] - old["rules"] or new["unique"] - old["unique"]:
            return True
        if new["required"] - old["required"]:
            return True
    return False


@pytest.mark.filterwarnings("ignore:Skipped unsupported reflection of expression-based index")
def test_no_migration_stops_earlier_versions_as_the_hosting_guide_says(empty: Settings) -> None:
    database, schemas = Database(empty.database_url), {}
    with database.engine.begin() as connection:
        for revision in reversed(_revisions()):
            command.upgrade(config(connection), revision)
            schemas[revision] = _schema(connection)
    database.close()

    stopping = {
        later
        for (earlier, later) in pairwise(schemas)
        if _takes_from(schemas[earlier], schemas[later])
    }

    # One that stops earlier versions has to be named in the guide: stop the service before it.
    guide = " ".join((ROOT / "docs/hosting.md").read_text().split())
    assert stopping == set()
    assert "Migrations only add to the schema, so web and worker processes" in guide
    assert _takes_from(schemas[_revisions()[0]], schemas[_revisions()[-1]])  # back, it would
