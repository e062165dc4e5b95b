"""A bridge in this process, and a client that speaks the protocol without a library for it."""

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from typing import Any

import orjson
import pytest
from websockets.sync.client import ClientConnection, connect

from seamark.bridge.rosbridge.axes import Axes
from seamark.bridge.rosbridge.lock_step import LockStep, Rules
from seamark.bridge.rosbridge.program import Bridge, RosProgram, opened
from seamark.bridge.rosbridge.server import TcpAddress
from seamark.sim.camera.optics import CURRENTS
from seamark.sim.vehicles.linkage_reading import load_linkage
from seamark.worker.ipc.outcomes import RunOutcome
from tests.seamark.bridge.conftest import PATIENCE_S, Running


class Client:
    """A client; what it gets beside what it waits for is in `others`."""

    def __init__(self, socket: ClientConnection) -> None:
        self.socket = socket
        self.others: list[dict[str, Any]] = []

    def send(self, **message: Any) -> None:
        self.socket.send(orjson.dumps(message).decode())

    def subscribe(self, topic: str, kind: str = "", **more: Any) -> None:
        self.send(op="subscribe", topic=topic, type=kind, **more)

    def command(self, surge: float, *, ns: int | None = None) -> None:
        twist = {"linear": {"x": surge, "y": 0.0, "z": 0.0}}
        if ns is None:
            self.send(op="publish", topic="/cmd_vel", msg=twist)
            return
        stamp = {"secs": ns // 10**9, "nsecs": ns % 10**9}
        message = {"header": {"stamp": stamp}, "twist": twist}
        self.send(op="publish", topic="/dataNavigator", msg=message)

    def receive(self, **wanted: Any) -> dict[str, Any]:
        """Return the next message with these values."""
        while True:
            message: dict[str, Any] = orjson.loads(self.socket.recv(timeout=PATIENCE_S))
            if wanted.items() <= message.items():
                return message
            self.others.append(message)

    def answer_all(self, topic: str, answer: Callable[[Any], float]) -> dict[str, Any]:
        """Answer each message of a topic until the result comes, and return that."""
        self.subscribe("/seamark/result")
        while True:
            message: dict[str, Any] = orjson.loads(self.socket.recv(timeout=PATIENCE_S))
            if message.get("topic") == "/seamark/result":
                result: dict[str, Any] = orjson.loads(message["msg"]["data"])
                return result
            if message.get("topic") == topic:
                self.command(answer(message["msg"]))
            else:
                self.others.append(message)


class Bridged:
    """A bridge, its clients and the run behind it."""

    def __init__(self, bridge: Bridge, stack: ExitStack) -> None:
        self.bridge = bridge
        self._stack = stack

    def start(self, **settings: Any) -> Running:
        arm = ARM if settings.get("arm") else None
        return Running(RosProgram(self.bridge, CURRENTS, arm), **settings)

    def steered(
        self, client: Client, topics: Iterable[str], *, surge: float, **settings: Any
    ) -> RunOutcome:
        """Run a program that always commands the same surge; topics come into `client.others`."""
        for topic in (*topics, "/seamark/error"):
            client.subscribe(topic)
        running = self.start(**settings)
        with ThreadPoolExecutor(1) as pool:
            answering = pool.submit(client.answer_all, "/seamark/error", lambda _message: surge)
            outcome = running.outcome()
            self.bridge.publish_result("{}")
            answering.result()
        return outcome

    def client(self, **options: Any) -> Client:
        url = f"ws://127.0.0.1:{self.bridge.port}"
        connecting = connect(url, compression=None, max_size=None, max_queue=None, **options)
        return Client(self._stack.enter_context(connecting))


ARM = load_linkage("alpha-like")
WITH_ARM: dict[str, Any] = {
    **{"benchmark": "currents-v2", "arm": ARM.name, "vehicle": "bluerov2-heavy-v2"},
    **{"levels": [0.1], "level_duration_s": 4.0},
}
Open = Callable[..., Bridged]


@pytest.fixture
def open_bridge() -> Iterator[Open]:
    """Open a bridge: `open_bridge(answer_within_s=1.0, axes=Axes.ENU)`."""
    with ExitStack() as stack:

        def start(
            *, answer_within_s: float = 30.0, axes: Axes = Axes.NED, joints: int = 0, **rules: Any
        ) -> Bridged:
            lock_step = LockStep(Rules(answer_s=answer_within_s, **rules), joints=joints)
            address = TcpAddress("127.0.0.1", 0)
            opening = opened(lock_step, address, say=lambda _sentence: None, axes=axes)
            return Bridged(stack.enter_context(opening), stack)

        yield start
