"""The last minutes of a qualification: every team submits and looks at its place.

`./run performance competition_rush [SECONDS]`. 200 teams submit five times each within the last
SECONDS of a round (600), through the HTTP API of a service with two web processes, and each looks
at the competition before and after; ten fake workers evaluate. Clients, web processes, database,
broker and workers share this machine. The baseline are the same pages a minute before the rush.
"""

import json
import os
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from http.client import HTTPConnection
from pathlib import Path

import numpy as np
from sqlalchemy import func, select, update

from performance.service.queue.fake_runs import FakeQueue, fake_worker
from performance.tables import aligned
from seamark.server.accounts import accounts
from seamark.server.accounts.permissions import Role
from seamark.server.competitions import competitions, teams
from seamark.server.competitions.competitions import CompetitionView
from seamark.server.database.competition_tables import Competition, Entry, Round
from seamark.server.database.schema import upgrade
from seamark.server.judging import boards, drafts, finals
from seamark.server.settings import Settings
from tests.services import postgres, valkey
from tests.services.ports import free_port

TEAMS, SUBMISSIONS, WORKERS, WEB = 200, 5, 10, 2
RUSH_S, RUN_S = 600.0, 4.0  # of the rush; of a run of a fake worker
QUIET_S = 20.0  # before the rush, for the baseline
LOOKS_S = 15.0  # between two looks of a team at the competition
THREADS = 24  # clients that send at the same time
IDLE_S = 1.0  # a connection that was idle for longer is not used again: the server may end it
START_S = 60.0
NAME, BENCHMARK = "rush-v1", "currents-v1"
ACCEPTED = 202


@dataclass
class Times:
    """How long requests took [s], and how they were answered."""

    took: dict[str, list[float]] = field(default_factory=dict)
    answers: Counter[int] = field(default_factory=Counter)
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def add(self, what: str, seconds: float, status: int) -> None:
        """Add one."""
        with self._lock:
            self.took.setdefault(what, []).append(seconds)
            if what == "submission":
                self.answers[status] += 1


class Client:
    """Requests of a team; each thread has one connection."""

    def __init__(self, port: int) -> None:
        self._port, self._local = port, threading.local()

    def request(self, path: str, token: str, body: object = None) -> tuple[int, float]:
        """Send a request and return its status and how long the answer took [s]."""
        connection, sent_at = getattr(self._local, "connection", (None, 0.0))
        if connection is None or time.monotonic() - sent_at > IDLE_S:
            connection = HTTPConnection("127.0.0.1", self._port)
        self._local.connection = connection, time.monotonic()
        headers = {"Authorization": f"Bearer {token}"} if token else {}
        content = None if body is None else json.dumps(body)
        if content is not None:
            headers["Content-Type"] = "application/json"
        begin = time.perf_counter()
        connection.request("GET" if body is None else "POST", path, content, headers)
        answer = connection.getresponse()
        answer.read()
        return answer.status, time.perf_counter() - begin


def main(arguments: Sequence[str]) -> None:
    """Run a rush and print what it took."""
    rush_s = float(arguments[0]) if arguments else RUSH_S
    with ExitStack() as held:
        print(_rush(held, rush_s))


def _rush(held: ExitStack, rush_s: float) -> str:
    folder = Path(held.enter_context(tempfile.TemporaryDirectory()))
    server = held.enter_context(postgres.server())
    values = {
        "data": folder,
        "database_url": held.enter_context(postgres.database(server.folder, "rush")),
        "broker_url": held.enter_context(valkey.on_port()),
        "workers": WORKERS,
        "secret_key": "s" * 40,
        "seed_key": "k" * 40,
    }
    settings = Settings.model_validate(values)
    upgrade(settings)
    queue = FakeQueue(settings, held)
    tokens = _compete(queue, rush_s)
    held.enter_context(fake_worker(settings, slots=WORKERS, run_s=RUN_S))
    queue.await_worker()
    port = held.enter_context(_web(settings))
    client, quiet, rush = Client(port), Times(), Times()
    with ThreadPoolExecutor(THREADS) as pool:
        _play(pool, _looks(client, quiet, tokens, QUIET_S))
        closes_at = time.time() + rush_s
        _close(queue, closes_at)
        jobs = [*_looks(client, rush, tokens, rush_s), *_submissions(client, rush, tokens, rush_s)]
        _play(pool, jobs)
        time.sleep(max(closes_at - time.time(), 0.0) + 0.1)
        late, _ = client.request("/api/v1/runs", tokens[0], _body(99))
    waited_s = _await_decision(queue, settings, closes_at)
    return "\n".join([_table(quiet, rush), "", *_counted(queue, rush, late, waited_s)])


def _compete(queue: FakeQueue, rush_s: float) -> list[str]:
    """Open a competition with its teams, and return a token of each."""
    now, settings = datetime.now(UTC), queue.settings
    times = {"opens": now - timedelta(hours=1), "closes": now + timedelta(hours=1, seconds=rush_s)}
    rounds = [{"kind": "qualification", "trials": 8, "quota": SUBMISSIONS, **times}]
    values = {"name": NAME, "title": "Rush", "benchmark": BENCHMARK, "rounds": rounds}
    draft = drafts.read(values, settings)
    secret = settings.seed_key.encode()
    with queue.database.writing() as session:
        olga = accounts.sign_up(session, "olga", None, role=Role.ORGANISER)
        competitions.create(
            session, olga.id, draft.document, picture=None, vehicle=None, secret=secret
        )
        session.execute(update(Competition).values(opened_at=time.time()))
    tokens = []
    for number in range(TEAMS):
        with queue.database.writing() as session:
            user = accounts.sign_up(session, f"captain{number}", None)
            teams.found(session, _view(queue), user.id, f"Team {number}")
            tokens.append(accounts.new_token(session, user.id, "rush", ["read", "submit"]))
    return tokens


def _view(queue: FakeQueue) -> CompetitionView:
    with queue.database.reading() as session:
        found = competitions.find(session, NAME)
    if found is None:
        raise RuntimeError("the competition is gone")
    return found


def _close(queue: FakeQueue, at: float) -> None:
    with queue.database.writing() as session:
        session.execute(update(Round).where(Round.number == 1).values(closes_at=at))


def _looks(
    client: Client, times: Times, tokens: Sequence[str], seconds: float
) -> Iterator[tuple[float, "Job"]]:
    """Yield looks of all teams at their competition, each every `LOOKS_S`, with when they are."""
    draw = np.random.default_rng(1)
    pages = (
        ("page", f"/competitions/{NAME}"),
        ("board", f"/api/v1/competitions/{NAME}/rounds/1/board"),
    )
    for token in tokens:
        at = draw.uniform(0.0, LOOKS_S)
        while at < seconds:
            what, path = pages[int(draw.integers(2))]
            yield at, Job(client, times, what, path, token)
            at += LOOKS_S


def _submissions(
    client: Client, times: Times, tokens: Sequence[str], seconds: float
) -> Iterator[tuple[float, "Job"]]:
    """Yield the submissions of all teams, more and more of them towards the end."""
    draw = np.random.default_rng(2)
    for token in tokens:
        for number in range(SUBMISSIONS):
            at = seconds * draw.random() ** 0.5 * 0.995
            yield at, Job(client, times, "submission", "/api/v1/runs", token, _body(number))


@dataclass(frozen=True)
class Job:
    """A request that is sent at its time."""

    client: Client
    times: Times
    what: str
    path: str
    token: str
    body: object = None

    def __call__(self) -> None:
        """Send it."""
        status, seconds = self.client.request(self.path, self.token, self.body)
        if status not in {200, ACCEPTED}:
            seconds = float("inf") if self.body is None else seconds
        self.times.add(self.what, seconds, status)


def _body(number: int) -> dict[str, object]:
    return {
        "benchmark": BENCHMARK,
        "controller": "pi",
        "config": {"kp": 0.1 + 0.01 * number},
        "competition": NAME,
        "method": "PI",
    }


def _play(pool: ThreadPoolExecutor, jobs: Iterable[tuple[float, Job]]) -> None:
    begin, sent = time.monotonic(), []
    for at, job in sorted(jobs, key=lambda each: each[0]):
        time.sleep(max(begin + at - time.monotonic(), 0.0))
        sent.append(pool.submit(job))
    for each in sent:
        each.result()


def _await_decision(queue: FakeQueue, settings: Settings, closes_at: float) -> float:
    """Wait until the round is decided, and return how long after its end that was [s]."""
    while _view(queue).ended_at is None:
        with queue.database.reading() as session:
            due = finals.undecided(session)
        for competition_id in due:
            with queue.database.writing() as session:
                finals.advance(session, competition_id, settings)
        time.sleep(1.0)
    return time.time() - closes_at


def _counted(queue: FakeQueue, rush: Times, late: int, waited_s: float) -> list[str]:
    """Return what became of the submissions."""
    view = _view(queue)
    with queue.database.reading() as session:
        entered = session.scalar(select(func.count()).select_from(Entry)) or 0
        scored = session.scalar(select(func.count()).where(Entry.score.is_not(None))) or 0
        board = boards.board(session, view, view.rounds[0])
    accepted = rush.answers[ACCEPTED]
    others = {status: count for status, count in rush.answers.items() if status != ACCEPTED}
    return [
        f"{TEAMS * SUBMISSIONS} submissions: {accepted} accepted, {others or 'none'} answered "
        f"otherwise, {entered} entries, {scored} with a score: {accepted - scored} lost",
        f"{sum(row.place is not None for row in board.rows)} of {TEAMS} teams have a place, "
        f"{waited_s:.0f} s after the end; a submission after the end was answered {late}",
    ]


def _table(quiet: Times, rush: Times) -> str:
    lines = [("what", "requests", "p50 ms", "p99 ms", "quiet p50 ms", "quiet p99 ms")]
    for what, took in rush.took.items():
        before = quiet.took.get(what, [])
        lines.append(
            (what, str(len(took)), *_quantiles(took), *(_quantiles(before) if before else "––"))
        )
    return aligned(lines)


def _quantiles(took: Sequence[float]) -> tuple[str, str]:
    cuts = statistics.quantiles(took, n=100)
    return f"{1e3 * cuts[49]:.1f}", f"{1e3 * cuts[98]:.1f}"


@contextmanager
def _web(settings: Settings) -> Iterator[int]:
    """Run the web processes, and give their port."""
    port = free_port()
    command = [sys.executable, "-m", "seamark.cli.main", "web", "--port", str(port)]
    command += ["--processes", str(WEB), "--data", str(settings.data)]
    environ = os.environ | settings.environment()
    with subprocess.Popen(command, env=environ, stderr=subprocess.DEVNULL) as web:
        try:
            _await_web(port)
            yield port
        finally:
            web.terminate()


def _await_web(port: int) -> None:
    until = time.monotonic() + START_S
    while True:
        try:
            if Client(port).request("/healthz", "")[0] == 200:
                return
        except OSError:
            if time.monotonic() > until:
                raise
        time.sleep(0.2)
