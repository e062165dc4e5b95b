"""The web server for real: slow clients, large bodies and restarts make nobody else wait."""

import threading
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager, suppress

import httpx
import numpy as np
import pytest

from seamark.sandbox.isolation.proc_stats import parent_of, tree
from seamark.server.accounts import accounts
from seamark.server.runs.data.files import RunFiles
from seamark.server.settings import Settings
from seamark.sim.recording.telemetry import WIDTH
from tests.cast import Backend
from tests.services import tables, web
from tests.services.asgi import answer_of
from tests.services.web import WebServer
from tests.worker.service.test_side_processes import eventually

SLOW = 150  # of each kind; together more than there ever were threads
ANSWER_S = 30.0  # generous: a page that waits for slow clients waits for good
GIB = 2**30
FILES = 700  # that a server may open; it accepts half as many connections, more than are slow
HEAD = b"POST /api/v1/runs HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory, _valkey: str) -> Iterator[WebServer]:
    """A server without users and runs, which may open few files."""
    values = {"data": tmp_path_factory.mktemp("web"), "broker_url": _valkey}
    settings = Settings.model_validate(values | {"secret_key": "only-for-tests"})
    tables.create(settings).close()
    with web.serving(settings, files=FILES) as serving:
        yield serving


def test_slow_clients_and_a_large_body_keep_nobody_waiting(server: WebServer) -> None:
    with ExitStack() as stack:
        for start in (HEAD, HEAD + b"Content-Length: 1000\r\n\r\n{"):
            stack.enter_context(web.slow_connections(server, SLOW, start))
        large = stack.enter_context(closing(server.connect()))
        large.sendall(HEAD + f"Content-Length: {GIB}\r\n\r\n".encode() + bytes(2**20))

        assert b"<h1" in server.get("/", timeout=ANSWER_S)
        answer, body = answer_of(large)

    assert answer.status == 413
    assert b"/problems/payload-too-large" in body


def test_upgrades_that_cannot_be_are_refused_and_use_up_no_file(server: WebServer) -> None:
    upgrade = b"Host: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    long = b"GET /?%s HTTP/1.1\r\n" % (b"a" * 9000) + upgrade

    with closing(server.connect()) as refused:
        refused.sendall(long + b"\r\n")
        answer, _ = answer_of(refused)
    for start in (b"", long, long + b"\r\n"):
        with ExitStack() as stack:
            for _ in range(FILES + FILES // 2):
                with suppress(ConnectionError):
                    stack.enter_context(closing(server.connect())).sendall(start)

            assert server.get("/healthz", timeout=ANSWER_S) == b"ok\n"
    log = server.log.read_text()

    assert answer.status == 414
    assert "out of system resource" not in log


@contextmanager
def _events(server: WebServer, run_id: int, headers: dict[str, str]) -> Iterator[Iterator[str]]:
    """Yield the lines of a stream."""
    path = f"{server.url}/api/v1/runs/{run_id}/events"
    with httpx.stream("GET", path, headers=headers, timeout=60) as answer:
        assert answer.status_code == 200
        yield answer.iter_lines()


def _until(lines: Iterator[str], start: str) -> str:
    return next(line for line in lines if line.startswith(start))


def test_a_restart_ends_streams_cleanly_and_breaks_no_page(backend: Backend) -> None:
    claim = backend.running("ann")
    files = RunFiles(backend.settings.data, claim.run_id, claim.attempt)
    files.append_rows(np.zeros((3, WIDTH)))
    with backend.database.writing() as session:
        token = accounts.new_token(session, backend.user_id("ann"), "stream", ("read",))
    headers = {"Authorization": f"Bearer {token}"}
    stop, pages = threading.Event(), list[int]()

    def visit(server: WebServer) -> None:
        while not stop.is_set():
            pages.append(httpx.get(f"{server.url}/healthz", timeout=60).status_code)

    with web.serving(backend.settings) as server:
        visitor = threading.Thread(target=visit, args=(server,))
        with _events(server, claim.run_id, headers) as lines:
            last_id = _until(lines, "id: ").removeprefix("id: ")
            visitor.start()
            server.restart_processes()
            rest = list(lines)  # ends without an error, although the run has not
        files.append_rows(np.ones((2, WIDTH)))
        with _events(server, claim.run_id, headers | {"Last-Event-ID": last_id}) as lines:
            resumed = _until(lines, 'data: {"columns"')
        stop.set()
        visitor.join()

    assert last_id == "1-3-0"
    assert "event: end" not in rest
    assert resumed.count("[") == 2 + 2  # columns, rows, and the two that are new
    assert set(pages) == {200}


def test_no_web_process_outlives_a_server_that_is_killed(server: WebServer) -> None:  # the last
    started = tree(server.process.pid)
    server.process.kill()
    server.process.wait()

    assert len(started) > 1
    assert eventually(lambda: not any(map(parent_of, started)))
