"""Programs that are connected to a run on the server: a real web server, broker and worker."""

import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from functools import partial
from os import environ, getpid
from typing import Any
from urllib.parse import urlencode

import orjson
import pytest
from sqlalchemy import update
from sqlalchemy.orm import Session
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection, connect

from seamark.bridge.rosbridge.server import TcpAddress
from seamark.cli.server_bridge import run_on_server
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.server.accounts import accounts
from seamark.server.app import create_app
from seamark.server.database.tables import Token, User
from seamark.server.messaging import bridge_sessions
from seamark.server.runs.record.states import RunState
from seamark.server.runs.showing.views import RunView
from seamark.server.web.streams import bridge_session, hub
from seamark.server.web.streams.access_watch import AccessWatch
from seamark.server.web.streams.bridge_session import REFUSED
from seamark.worker.evaluation.local import evaluate_locally
from seamark.worker.evaluation.worker_slot import WorkerSlot
from seamark.worker.zygote.client import Mother
from tests.seamark.bridge.conftest import BENCHMARK, SEED, SHORT, configuration
from tests.seamark.bridge.rosbridge.conftest import PATIENCE_S, Client
from tests.services import forked_workers
from tests.services.asgi import serving
from tests.services.ports import free_port
from tests.worker.conftest import POLL_S, START_S, Service

pytestmark = [pytest.mark.slow, pytest.mark.host]
LANE = "w1@here/bridges-1"
# Half of the service's times and less: most of the time of these tests would be spent on them.
PRESENT_S, RENEW_S, OFFER_S = 4, 0.5, 1.0
IMPATIENT = f"""
import sys
from seamark.server.messaging import bridge_sessions
bridge_sessions.PRESENT_S, bridge_sessions.RENEW_S = {PRESENT_S}, {RENEW_S}
from seamark.worker.service.bridge_loop import main
main(*sys.argv[1:])
"""
GIVEN = {"benchmark": BENCHMARK, "seed": str(SEED), "config": orjson.dumps(SHORT).decode()}


@dataclass
class Site:
    """A web server, and one slot for connected programs."""

    service: Service
    address: str
    stack: ExitStack
    mother: Mother
    process: "subprocess.Popen[bytes]"

    def token(self, who: str) -> str:
        with self.service.database.writing() as session:
            user_id = self.service.user_id(who)
            return accounts.new_token(session, user_id, "t", ("read", "submit"), days=1)

    def connect(self, who: str, **query: str) -> ClientConnection:
        """Connect a program; waits for the slot that the test before has left."""
        url = f"ws://{self.address}/api/v1/rosbridge?{urlencode(GIVEN | query)}"
        headers = {"Authorization": f"Bearer {self.token(who)}"}
        opening = connect(
            url, additional_headers=headers, max_size=None, compression=None, max_queue=None
        )
        return self.stack.enter_context(opening)

    def connect_when_free(self, who: str, **query: str) -> Client:
        deadline = time.monotonic() + START_S
        while time.monotonic() < deadline:
            with suppress(InvalidStatus):
                return Client(self.connect(who, **query))
            time.sleep(0.2)
        raise TimeoutError("no slot became free")

    def restart_process(self) -> None:
        self.process.kill()
        self.process.wait()
        self.process = process_of(self.service, self.mother)

    def ended(self, client: Client) -> RunView:
        return self.service.ended(run_of(client))


def process_of(service: Service, mother: Mother) -> "subprocess.Popen[bytes]":
    asked = mother.descriptor
    arguments = ["-s", "-P", "-c", IMPATIENT, str(getpid()), LANE, str(asked)]
    environment = environ | service.settings.environment()
    return subprocess.Popen([sys.executable, *arguments], env=environment, pass_fds=[asked])


def run_of(client: Client) -> int:
    assert client.socket.response is not None
    return int(client.socket.response.headers["Location"].removeprefix("/api/v1/runs/"))


@pytest.fixture(scope="module")
def _site(_bare: Service) -> Iterator[Site]:
    with ExitStack() as stack:
        patch = stack.enter_context(pytest.MonkeyPatch.context())
        patch.setattr(bridge_sessions, "PRESENT_S", PRESENT_S)
        patch.setattr(bridge_session, "RENEW_S", RENEW_S)
        patch.setattr(bridge_session, "OFFER_S", OFFER_S)
        patch.setattr(hub, "AccessWatch", partial(AccessWatch, every_s=RENEW_S))
        app = create_app(_bare.settings)
        connecting = stack.enter_context(serving(app))
        with connecting(b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n") as probe:
            host, port = probe.getpeername()
        mother = forked_workers.mother(WorkerSlot(IsolationLevel.NONE, None))
        site = Site(_bare, f"{host}:{port}", stack, mother, process_of(_bare, mother))
        yield site
        site.process.terminate()
        site.process.wait()
        mother.stop()
        app.extensions["seamark"].close()


@pytest.fixture
def site(_site: Site) -> Iterator[Site]:
    with ExitStack() as stack:
        _site.stack = stack
        yield _site


def _revoke(session: Session, token: Token) -> None:
    assert accounts.revoke_token(session, token.user_id, token.id)


def _expire(session: Session, token: Token) -> None:
    session.get_one(Token, token.id).expires_at = time.time()


def _receive_all(client: Client) -> None:
    while True:
        client.socket.recv(timeout=PATIENCE_S)


def _surge(message: Any) -> float:
    return float(message["vector"]["x"])


@pytest.mark.parametrize(("axes", "frame"), [("ned", "base_link_frd"), ("enu", "base_link")])
def test_a_program_has_the_digest_on_the_server_that_it_has_here(
    site: Site, axes: str, frame: str
) -> None:
    here = evaluate_locally(BENCHMARK, configuration(), seed=SEED, controller="nothing")
    client, frames = site.connect_when_free("ann", axes=axes), set[str]()
    client.subscribe("/seamark/error")

    def answer(message: Any) -> float:
        frames.add(message["header"]["frame_id"])
        return 0.0

    result = client.answer_all("/seamark/error", answer)

    run = site.ended(client)
    assert frames == {frame}
    assert result["digest"] == run.digest == here.digest
    assert run.state is RunState.SUCCEEDED
    assert (run.kind, run.controller) == ("practice", "rosbridge")
    assert site.service.files(run.id).row_count() == 2 * 40
    with pytest.raises(ConnectionClosed):
        client.socket.recv(timeout=PATIENCE_S)


def test_a_program_on_another_machine_takes_part_through_the_command(site: Site) -> None:
    token, said = site.token("ann"), list[str]()
    wanted = {"benchmark": BENCHMARK, "config": SHORT, "seed": SEED, "trials": None}
    port = free_port()

    with ThreadPoolExecutor(1) as pool:
        before = site.connect_when_free("ann")
        before.socket.close()
        site.ended(before)  # or the command would find no slot, and wait for seconds to try again
        address = TcpAddress("127.0.0.1", port)
        url = f"http://{site.address}"
        ending = pool.submit(run_on_server, url, token, wanted, address, said.append)
        client = Client(_connected(site, f"ws://127.0.0.1:{port}"))
        client.subscribe("/seamark/error")
        result = client.answer_all("/seamark/error", _surge)
        run = ending.result(timeout=START_S)

    assert run.state == "succeeded"
    assert run.document["result"]["digest"] == result["digest"]
    assert said[-1].startswith(f"Run {run.id}: {url}/runs/")


def test_an_account_has_one_session_and_whoever_finds_no_slot_is_told_to_try_again(
    site: Site,
) -> None:
    client = site.connect_when_free("ann")
    with pytest.raises(InvalidStatus) as second:
        site.connect("ann")
    with pytest.raises(InvalidStatus) as other:
        site.connect("ben")

    assert second.value.response.status_code == 409
    assert other.value.response.status_code == 503
    assert int(other.value.response.headers["Retry-After"]) > 0
    client.socket.close()
    after = site.connect_when_free("ben")  # it has the slot

    run = site.ended(client)
    assert run.cause == "user_error"
    assert "The program disconnected" in run.detail["sentence"]
    assert site.service.show(run_of(after)).state is RunState.RUNNING


def test_cancelling_the_run_closes_the_connection(site: Site) -> None:
    client = site.connect_when_free("ann")
    client.subscribe("/seamark/error")
    client.receive(op="publish")

    assert site.service.cancel(run_of(client))

    with pytest.raises(ConnectionClosed):
        client.socket.recv(timeout=PATIENCE_S)
    assert site.ended(client).state is RunState.CANCELLED


@pytest.mark.parametrize("end", [_revoke, _expire])
def test_a_session_ends_with_its_token_and_its_run_is_cancelled(
    site: Site, end: Callable[[Session, Token], None]
) -> None:
    site.token("eva")
    long = SHORT | {"level_duration_s": 600.0}
    client = site.connect_when_free("eva", config=orjson.dumps(long).decode())
    client.subscribe("/seamark/error")
    with site.service.database.writing() as session:
        newest, *others = accounts.tokens(session, site.service.user_id("eva"))
        end(session, others[-1])  # the control: it has nothing to do with the session
    until = time.monotonic() + 2 * RENEW_S
    while time.monotonic() < until:
        client.receive(op="publish")
        client.command(0.0)
        time.sleep(POLL_S)  # so that the simulator rests meanwhile
    assert site.service.show(run_of(client)).state is RunState.RUNNING

    with site.service.database.writing() as session:
        end(session, newest)

    with pytest.raises(ConnectionClosed) as closed:
        _receive_all(client)
    assert closed.value.rcvd is not None
    assert (closed.value.rcvd.code, closed.value.rcvd.reason) == (1008, REFUSED)
    assert site.ended(client).state is RunState.CANCELLED


def test_what_a_program_says_wrongly_is_in_the_log_of_its_run(site: Site) -> None:
    client = site.connect_when_free("ann")
    client.subscribe("/seamark/error")
    client.receive(op="publish")
    client.send(op="publish", topic="/dev/null", msg={})
    client.receive(op="status")
    client.command(0.0)
    client.answer_all("/seamark/error", lambda _message: 0.0)

    run = site.ended(client)

    log = site.service.files(run.id).log_text()
    assert "[The program has connected.]" in log
    assert "/dev/null: publish on /cmd_vel" in log


def test_an_account_without_quota_is_refused(site: Site) -> None:
    site.connect_when_free("ann").socket.close()
    with site.service.database.writing() as session:
        session.execute(update(User).where(User.name == "eva").values(quota_day=0))

    refusal = _refusal(lambda: site.connect("eva"))

    assert refusal.response.status_code == 429
    assert "24" in orjson.loads(bytes(refusal.response.body or b""))["detail"]


def test_a_run_whose_slot_dies_fails_and_is_not_repeated(site: Site) -> None:
    client = site.connect_when_free("ann")
    client.subscribe("/seamark/error")
    client.receive(op="publish")
    client.command(0.0)
    client.receive(op="publish")

    site.restart_process()

    run = site.ended(client)
    assert (run.state, run.cause, run.attempt) == (RunState.FAILED, "platform_error", 1)
    assert "lost the connection" in run.detail["sentence"]
    with pytest.raises(ConnectionClosed, match="lost the connection"):
        client.socket.recv(timeout=PATIENCE_S)


def _refusal(attempt: Callable[[], object]) -> InvalidStatus:
    """Return why an attempt was refused, when a slot is free."""
    deadline = time.monotonic() + START_S
    while True:
        with pytest.raises(InvalidStatus) as refused:
            attempt()
        if refused.value.response.status_code != 503:
            return refused.value
        assert time.monotonic() < deadline
        time.sleep(0.2)


def _connected(site: Site, url: str) -> ClientConnection:
    """Connect to a command that is about to listen."""
    deadline = time.monotonic() + START_S
    while True:
        try:
            return site.stack.enter_context(connect(url, max_size=None, compression=None))
        except OSError:
            assert time.monotonic() < deadline
            time.sleep(0.02)
