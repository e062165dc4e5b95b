"""Whether the service says in time that it is not ready, and only then."""

import socket
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import pytest
from flask.testing import FlaskClient
from sqlalchemy import update

from seamark.server.app import create_app
from seamark.server.database.tables import Worker
from seamark.server.messaging import broker, workers
from seamark.server.monitoring.outages import Outage
from seamark.server.settings import Settings
from seamark.server.web.readiness import Readiness
from tests.cast import Backend

WORKER = "host"


@pytest.fixture
def silent_port() -> Iterator[int]:
    """The port of a server that accepts connections and never says anything."""
    with socket.create_server(("127.0.0.1", 0), backlog=64) as server:
        port: int = server.getsockname()[1]
        yield port


@pytest.fixture
def client_of_silence(settings: Settings, silent_port: int) -> FlaskClient:
    silent = {
        "database_url": f"postgresql+psycopg://nobody@127.0.0.1:{silent_port}/none",
        "broker_url": f"redis://127.0.0.1:{silent_port}/0",
    }
    app = create_app(settings.model_copy(update=silent))
    return app.test_client(use_cookies=False)


@pytest.mark.slow
def test_a_part_that_hangs_is_named_before_it_answers(client_of_silence: FlaskClient) -> None:
    checks = client_of_silence.get("/readyz").get_json()["checks"]

    silent = "does not answer"  # its own limits of 5 and 10 s would say something else
    assert (checks["database"], checks["broker"], checks["queue"]) == (silent, silent, "unknown")


@pytest.mark.slow
def test_parts_that_hang_cost_one_thread_each(client_of_silence: FlaskClient) -> None:
    with ThreadPoolExecutor(8) as pool:
        answers = list(pool.map(lambda _: client_of_silence.get("/readyz").status_code, range(8)))

    assert set(answers) == {503}


def _readiness(backend: Backend) -> Readiness:
    redis, outage = broker.connect(backend.settings), Outage("database")
    return Readiness(backend.settings, backend.database, redis, outage, idle_s=0.0)


def _register(backend: Backend, *, slots: int = 2, languages: tuple[str, ...] = ()) -> None:
    with backend.database.writing() as session:
        row = Worker(
            name=WORKER, slots=slots, level="strong", languages=list(languages), findings=[]
        )
        workers.register(session, row)


def test_a_service_in_which_no_run_starts_beside_free_slots_is_not_ready(both: Backend) -> None:
    _register(both)
    both.queue("ann")
    readiness = _readiness(both)

    first, second = readiness.checks()["queue"], readiness.checks()["queue"]

    assert first == "ok"  # it may be claimed just now
    assert second.startswith("slots are free, but no run started for")


def test_a_run_that_starts_in_between_shows_that_claims_work(both: Backend) -> None:
    _register(both, slots=8)
    for name in ("ann", "ben", "eva"):
        both.queue(name)
    readiness = _readiness(both)

    seen = [readiness.checks()["queue"] for _ in range(2) if both.claim(f"{WORKER}/0")]

    assert seen == ["ok", "ok"]


@pytest.mark.parametrize(
    "reason", ["full", "drained", "preparing", "language", "limit", "nothing waits"]
)
def test_a_service_whose_runs_wait_for_a_reason_is_ready(both: Backend, reason: str) -> None:
    places = 1 if reason == "full" else 2
    if reason == "language":
        both.queue_program("ann")
    _register(both, slots=places)
    if reason not in ("language", "nothing waits"):
        both.queue("ann")
    if reason == "limit":  # with two places an owner has one of them
        both.queue("ann")
    if reason in ("full", "limit"):
        both.claim(f"{WORKER}/0")
        both.queue("ben" if reason == "full" else "ann")
    with both.database.writing() as session:
        if reason == "drained":
            workers.drain(session, WORKER)
        if reason == "preparing":
            states = {workers.SIMULATOR: workers.preparing(1, 6)}
            session.execute(update(Worker).values(processes=states))
    readiness = _readiness(both)

    seen = {readiness.checks()["queue"] for _ in range(3)}

    assert seen == {"ok"}
