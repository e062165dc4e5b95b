"""What a request reads of a large database: a few rows, however many runs there are."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Any

import pytest
from flask.testing import FlaskClient
from sqlalchemy import Connection
from sqlalchemy.orm import Session

from performance.service.database import queries as asked
from performance.service.database.queries import Asked
from performance.service.database.requests import BENCHMARK, addresses, create_first
from performance.service.database.runs_table import fill
from seamark.server.accounts.permissions import Viewer
from seamark.server.app import create_app
from seamark.server.runs.downloads.conversions import Conversions
from seamark.server.runs.leaderboard import leaderboard
from seamark.server.runs.queue import lost_attempts
from seamark.server.runs.queue import queue as run_queue
from seamark.server.runs.record.states import RunState
from seamark.server.runs.showing import run_lists
from seamark.server.runs.showing.run_lists import ListCursor, RunFilter
from seamark.server.web import authentication
from tests.cast import Backend
from tests.server.api.conftest import Site

RUNS, QUEUED = 30_000, 1_000
ROWS_MAX = 5_000  # rows of all tables that one statement reads on PostgreSQL
QUERIES_MAX = 18  # of one answer
CONNECTIONS_MAX = 2  # of a page that everybody opens: for its viewer, and for the rest
STEPS_MAX = 75_000  # steps of SQLite's virtual machine; a scan of `runs` takes more
_STEPS = 500  # between two calls of its handler


@dataclass
class Work:
    """What the statements of one database cost."""

    site: Site
    found: list[tuple[str, Any]] = field(default_factory=list)

    @contextmanager
    def recorded(self) -> Iterator[Asked]:
        """Record the statements that are executed meanwhile."""
        with asked.recorded(self.site.services.database.engine) as found:
            yield found
        self.found += found.statements

    def of_get(self, client: FlaskClient, address: str) -> tuple[int, int]:
        """Return how many queries and connections the answer to a GET takes."""
        with asked.recorded(self.site.services.database.engine) as found:
            answer = client.get(address)
        assert answer.status_code == 200
        return found.queries, found.connections

    def heavy(self) -> list[tuple[str, int]]:
        """Return the recorded statements that read more than a few rows, with their number."""
        costs = []
        engine = self.site.services.database.engine
        with engine.connect() as connection:
            on_postgresql = engine.dialect.name == "postgresql"
            cost = _rows_read if on_postgresql else _steps
            most = ROWS_MAX if on_postgresql else STEPS_MAX
            for statement, values in dict((str(each), each) for each in self.found).values():
                if statement.startswith(("SELECT", "UPDATE", "DELETE")):
                    costs.append((statement, cost(connection, statement, values)))
            connection.rollback()
        self.found.clear()
        return [(statement, number) for statement, number in costs if number > most]


def _rows_read(connection: Connection, statement: str, values: Any) -> int:
    explain = f"EXPLAIN (ANALYZE, FORMAT JSON) {statement}"
    [[[document]]] = connection.exec_driver_sql(explain, values).all()
    return _of_scans(document["Plan"])


def _of_scans(node: dict[str, Any]) -> int:
    rows = sum(map(_of_scans, node.get("Plans", ())))
    if "Scan" in node["Node Type"] and not node.get("Plans"):
        removed = node.get("Rows Removed by Filter", 0)
        rows += round((node["Actual Rows"] + removed) * node["Actual Loops"])
    return rows


def _steps(connection: Connection, statement: str, values: Any) -> int:
    count = 0

    def step() -> None:
        nonlocal count
        count += 1

    driver = connection.connection.driver_connection
    assert driver is not None
    driver.set_progress_handler(step, _STEPS)
    connection.exec_driver_sql(statement, values).all() if statement.startswith(
        "SELECT"
    ) else connection.exec_driver_sql(statement, values)
    driver.set_progress_handler(None, 0)
    return count * _STEPS


@pytest.fixture
def work(both: Backend) -> Iterator[Work]:
    app = create_app(both.settings)
    site = Site(**vars(both), app=app, headers={})
    # A file is written by a process that is told the rows, and asks no database.
    written = Conversions(command=("true",))
    app.extensions["seamark"] = replace(site.services, conversions=written)
    yield Work(site)
    site.services.close()


def _admin(site: Site) -> FlaskClient:
    """Return a browser in which an admin is signed in."""
    client = site.client()
    with site.app.app_context():
        cookie = authentication.cookie_of(site.user_id("root"))
    with client.session_transaction() as session:
        session.update(cookie)
    return client


def _all_failed(session: Session, viewer: Viewer) -> list[int]:
    """Return the failed runs by following a list with a filter that few runs pass."""
    found, start = list[int](), ListCursor()
    run_filter = RunFilter(which="all", states=(RunState.FAILED, RunState.CANCELLED))
    while True:
        page = run_lists.page(session, viewer, run_filter, start=start)
        found += [run.id for run in page.runs]
        if page.next is None:
            return found
        start = page.next


@pytest.mark.slow
def test_no_request_and_no_step_of_the_queue_scans_the_runs(work: Work) -> None:
    site = work.site
    recorded = site.recorded()
    fill(site.database, runs=RUNS, queued=QUEUED)
    with site.database.writing() as session:
        create_first(session, site.user_id("root"))
    waiting = site.queue("ann")
    with site.database.reading() as session:
        half = leaderboard.page(session, BENCHMARK, limit=200)[-1].cursor.text()
    client = _admin(site)

    heavy, many, refused = {}, {}, []
    for address in addresses(site.app, run_id=recorded, half=half):
        with work.recorded() as found, client.get(address) as answer:
            answer.get_data()
        many[address] = found.queries
        if "?" in address and answer.status_code != 200:
            refused.append(address)  # then it would not be the page that is meant
        heavy[address] = work.heavy()
    with work.recorded():
        site.show(waiting)
    heavy["position"] = work.heavy()
    with site.database.reading() as session:
        failed = _all_failed(session, site.viewers["root"])

    assert refused == []
    assert len(failed) == len(set(failed)) == (RUNS - QUEUED) // 100
    assert failed == sorted(failed, reverse=True)
    assert {what: statements for what, statements in heavy.items() if statements} == {}
    assert {what: count for what, count in many.items() if count > QUERIES_MAX} == {}


@pytest.mark.slow
def test_the_pages_that_everybody_opens_ask_as_much_of_a_few_entries_as_of_many(work: Work) -> None:
    site, most = work.site, {"/": 11, f"/leaderboards/{BENCHMARK}": 10}
    client = _admin(site)
    site.published("ann", kind="ranked", benchmark=BENCHMARK)
    site.published("ben", kind="ranked", benchmark=BENCHMARK)

    few = {address: work.of_get(client, address) for address in most}
    fill(site.database, runs=3_000, queued=600)
    many = {address: work.of_get(client, address) for address in most}

    assert work.site.client().get(f"/leaderboards/{BENCHMARK}").text.count('name="runs"') == 50
    assert many == few
    assert {address: found for address, found in many.items() if found[0] > most[address]} == {}
    assert {connections for _, connections in many.values()} == {CONNECTIONS_MAX}


@pytest.mark.slow
def test_claims_submissions_and_sweeps_cost_the_same_at_any_depth(work: Work) -> None:
    site = work.site
    fill(site.database, runs=RUNS, queued=QUEUED)
    database = site.services.database
    heavy = {}

    with work.recorded():
        run_queue.claim(database, "w", languages=("python",), settings=site.settings)
    heavy["claim"] = work.heavy()
    with work.recorded(), database.writing() as session:
        leases = lost_attempts.leases(session)
        lost_attempts.recover(session, leases, site.settings)
        lost_attempts.tidy(session)
    heavy["sweep"] = work.heavy()
    client = site.client()
    with work.recorded():
        answer = client.post("/api/v1/runs", json={"benchmark": BENCHMARK, "controller": "pi"})
    heavy["submit"] = work.heavy()

    assert (len(leases), answer.status_code) == (1, 202)
    assert {what: statements for what, statements in heavy.items() if statements} == {}
