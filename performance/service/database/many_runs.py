"""Pages and queue of a full database: `./run performance many_runs [RUNS QUEUED REPEATS]`.

Fills SQLite and a private PostgreSQL and calls every address that answers GET, alternately on the
full and on an empty database, without the network; beside the times it prints how many queries and
connections of the pool an answer takes. Then it claims, submits, asks for positions and recovers.
Queries that take long are printed with their plans.
"""

import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from flask import Flask
from flask.testing import FlaskClient
from sqlalchemy import update

from performance.service.database.queries import plans, recorded, slow_queries
from performance.service.database.requests import BENCHMARK, addresses, create_first
from performance.service.database.runs_table import fill
from seamark.server.accounts import accounts
from seamark.server.accounts.permissions import Role, Viewer
from seamark.server.app import create_app, prepare
from seamark.server.database.engine import Database
from seamark.server.database.schema import upgrade
from seamark.server.database.tables import Run
from seamark.server.runs.leaderboard import leaderboard
from seamark.server.runs.leaderboard.board_rows import Cursor
from seamark.server.runs.queue import lost_attempts
from seamark.server.runs.queue import queue as run_queue
from seamark.server.runs.record.states import RunState
from seamark.server.runs.showing import views
from seamark.server.runs.submission import submission, validation
from seamark.server.runs.submission.validation import Submission
from seamark.server.settings import Settings
from seamark.server.web import authentication
from tests.services import postgres, valkey

RUNS, QUEUED = 1_000_000, 10_000
REPEATS = 100
_HEAD = f"{'':72}{'p50':>8}{'p99':>8}{'empty p50':>11}{'p99':>8} [ms]  queries  connections"


@dataclass
class Service:
    """An application on one database, and somebody who may see everything."""

    app: Flask
    settings: Settings
    database: Database
    client: FlaskClient
    viewer: Viewer
    run_id: int  # one that ended
    waiting_id: int = 0

    @classmethod
    def start(cls, settings: Settings, *, runs: int, queued: int) -> "Service":
        """Create the tables, an admin and the runs."""
        upgrade(settings)
        app = create_app(settings)
        database = app.extensions["seamark"].database
        with database.writing() as session:
            user = accounts.sign_up(session, "root", None, role=Role.ADMIN)
            viewer = Viewer(user_id=user.id, name=user.name, account_role=Role.ADMIN)
            create_first(session, user.id)
        made = cls(app, settings, database, app.test_client(), viewer, 0)
        made.run_id = made.submit()
        claim = run_queue.claim(database, "w", languages=(), settings=settings)
        with database.writing() as session:
            ended = {"state": RunState.SUCCEEDED, "finished_at": time.time()}
            session.execute(update(Run).where(Run.id == made.run_id).values(**ended))
        if claim is None:
            raise RuntimeError("the only run in the queue was not claimed")
        fill(database, runs=runs, queued=queued)
        made.waiting_id = made.submit()
        with app.app_context():
            cookie = authentication.cookie_of(user.id)
        with made.client.session_transaction() as session:
            session.update(cookie)
        return made

    def get(self, address: str) -> None:
        """Read an address to its end."""
        with self.client.get(address) as answer:
            answer.get_data()
        if answer.status_code >= 500 and address != "/readyz":  # there is no worker
            raise RuntimeError(f"{address}: {answer.status}")

    def submit(self) -> int:
        """Submit a run and return its id."""
        wanted = Submission(viewer=self.viewer, benchmark=BENCHMARK, config={}, controller="pi")
        valid = validation.validate(wanted, self.settings)
        with self.database.writing() as session:
            return submission.submit(session, valid, self.settings)

    def claim(self) -> None:
        """Claim a run."""
        run_queue.claim(self.database, "w", languages=("python",), settings=self.settings)

    def sweep(self) -> None:
        """Look for abandoned leases."""
        with self.database.writing() as session:
            lost_attempts.recover(session, {}, self.settings)
            lost_attempts.tidy(session)

    def position(self) -> None:
        """Ask for the position and the estimate of the last run."""
        with self.database.reading() as session:
            views.show(session, self.waiting_id, self.settings)

    def half(self) -> str:
        """Return a cursor within the leaderboard."""
        with self.database.reading() as session:
            ranks = leaderboard.page(session, BENCHMARK, limit=500)
        return (ranks[-1].cursor if ranks else Cursor(50.0, 1.0, 1)).text()


def measured(full: Callable[[], object], empty: Callable[[], object], repeats: int) -> str:
    """Return the columns of a line: percentiles of the wall times [ms] of both, alternately."""
    times = np.empty((repeats, 2))
    for call in (full, empty):
        call()
    for number in range(repeats):
        for column, call in enumerate((full, empty)):
            start = time.perf_counter()
            call()
            times[number, column] = 1e3 * (time.perf_counter() - start)
    (p50, empty_p50), (p99, empty_p99) = np.percentile(times, (50, 99), axis=0)
    return f"{p50:8.1f}{p99:8.1f}{empty_p50:11.1f}{empty_p99:8.1f}"


def lines(full: Service, empty: Service, repeats: int) -> Iterator[str]:
    """Measure a full service beside an empty one and yield the lines of a table."""
    slow: dict[str, object] = {}
    routes = addresses(full.app, run_id=full.run_id, half=full.half())
    with slow_queries(full.database.engine, slow):
        for address in routes:
            figures = measured(
                lambda a=address: full.get(a),  # type: ignore[misc]
                lambda a=address: empty.get(a),  # type: ignore[misc]
                repeats,
            )
            with recorded(full.database.engine) as asked:
                full.get(address)
            yield f"GET {address:68}{figures}{asked.queries:14}{asked.connections:13}"
        for name in ("position", "submit", "claim", "sweep"):
            figures = measured(getattr(full, name), getattr(empty, name), repeats)
            yield f"{name:72}{figures}"
    yield from plans(full.database.engine, slow)


def tables(runs: int = RUNS, queued: int = QUEUED, repeats: int = REPEATS) -> Iterator[str]:
    """Fill both databases and yield the lines of their tables as soon as they are measured."""
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        broker_url = stack.enter_context(valkey.on_socket())
        server = stack.enter_context(postgres.server())
        for name in ("sqlite", "postgresql"):
            pair = []
            for size, waiting in ((runs, queued), (1, 0)):
                url = f"sqlite:///{folder}/{size}.db"
                if name == "postgresql":
                    url = stack.enter_context(postgres.database(server.folder, f"runs{size}"))
                values = {"data": folder / f"{name}{size}", "database_url": url}
                many = {"quota_live": 10**6, "quota_day": 10**6, "quota_bytes": 10**15}
                settings = Settings.model_validate(values | {"broker_url": broker_url} | many)
                service = Service.start(settings, runs=size, queued=waiting)
                stack.enter_context(closing(service.app.extensions["seamark"]))
                pair.append(service)
            prepare()
            yield f"\n{name}: {runs} runs, {queued} queued\n{_HEAD}"
            yield from lines(pair[0], pair[1], repeats)


def table() -> str:
    """Return the tables of a million runs."""
    return "\n".join(tables())


def main(arguments: Sequence[str]) -> int:
    """Print the lines as soon as they are measured."""
    for line in tables(*map(int, arguments)):
        print(line, flush=True)
    return 0
