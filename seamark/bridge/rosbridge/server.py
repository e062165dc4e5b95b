"""The WebSocket server of a bridge: it carries out the operations of its clients."""

import asyncio
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from websockets.asyncio.server import ServerConnection, serve, unix_serve
from websockets.exceptions import ConnectionClosed

from seamark.bridge.rosbridge.axes import Axes
from seamark.bridge.rosbridge.client import MOST_SUBSCRIPTIONS, Client
from seamark.bridge.rosbridge.lock_step import LockStep
from seamark.bridge.rosbridge.protocol import (
    LONGEST_MESSAGE,
    Advertise,
    CallService,
    Operation,
    Publish,
    Refused,
    SetAxes,
    SetLevel,
    Subscribe,
    Unadvertise,
    Unsubscribe,
    read,
)
from seamark.bridge.rosbridge.topics import (
    JOINT_SPEEDS,
    JOINT_SPEEDS_TYPE,
    REFERENCES,
    RESULT,
    TOPICS,
    Moment,
    Ros,
    Topic,
    resolved,
)
from seamark.sim.engine.program import Command

MOST_CLIENTS = 8
CLOSE_WITHIN_S = 2.0  # [s] for a client to agree to the end of the connection
TRY_AGAIN_LATER = 1013  # close code, IANA WebSocket registry
# Pages of this machine; a browser lets every page of the web connect to it.
LOCAL_ORIGIN = re.compile(r"https?://(localhost|127\.0\.0\.1|\[::1\])(:\d+)?")
RESULT_TOPIC = Topic("std_msgs", "String", "once: how the run ended, as JSON", lambda _now, _to: {})


class Server:
    """The clients of one run. Belongs to the event loop."""

    def __init__(self, lock_step: LockStep, say: Callable[[str], None], axes: Axes) -> None:
        """`say` gets sentences for the one who started the bridge; `axes` are those of clients."""
        self._lock_step = lock_step
        self._axes = axes
        self._say = say
        self._clients: set[Client] = set()

    async def exchange(self, now: Moment) -> Command:
        """Publish an observation and return the reference that answers it; raises ProgramEnded."""
        return await self._lock_step.exchange(now, self._clients)

    async def publish_result(self, text: str) -> None:
        """Publish how the run ended."""
        for client in tuple(self._clients):
            await client.publish_result(RESULT, {"data": text})

    async def handle(self, connection: ServerConnection) -> None:
        """Serve one connection until it closes."""
        if len(self._clients) >= MOST_CLIENTS:
            await connection.close(TRY_AGAIN_LATER, f"at most {MOST_CLIENTS} clients")
            return
        client = Client(connection, self._axes)
        self._clients.add(client)
        self._say(f"{client.address} has connected.")
        try:
            async for message in connection:
                await self._carry_out(client, message)
        except ConnectionClosed:
            pass
        finally:
            self._clients.discard(client)
            self._lock_step.disconnected(client)
            self._say(f"{client.address} has disconnected.")

    async def _carry_out(self, client: Client, message: str | bytes) -> None:
        try:
            await self._dispatch(client, read(message))
        except Refused as refusal:
            self._lock_step.refused(client, str(refusal))
            self._say(f"{client.address}: {refusal}")
            await client.status("error", str(refusal), refusal.reply_to)

    async def _dispatch(self, client: Client, operation: Operation) -> None:
        match operation:
            case Publish():
                _check_reference(operation.topic)
                of_arm = resolved(operation.topic) == JOINT_SPEEDS
                take = self._lock_step.take_joint_speeds if of_arm else self._lock_step.take
                take(client, operation)
            case Advertise():
                _check_reference(operation.topic)
                self._lock_step.become_controller(client, operation.topic)
            case Unadvertise():
                self._lock_step.release(client)
            case Subscribe():
                await self._subscribe(client, operation)
            case Unsubscribe():
                client.unsubscribe(operation)
            case CallService():
                await client.send(_service_response(operation))
            case SetLevel() | SetAxes():
                client.prefer(operation)

    async def _subscribe(self, client: Client, order: Subscribe) -> None:
        """Subscribe a client, and send it what waits for an answer now: topics are latched."""
        name = resolved(order.topic)
        topic = RESULT_TOPIC if name == RESULT else TOPICS.get(name)
        if topic is None:
            raise Refused(f"There is no topic {order.topic}.", reply_to=order.id)
        ros = topic.ros_of(order.type)
        if ros is None:
            right = topic.type_in(Ros.ONE)
            text = f"{order.topic} has messages of type {right}, not {order.type}."
            raise Refused(text, reply_to=order.id)
        if not client.subscribe(order, ros):
            text = f"A client may have at most {MOST_SUBSCRIPTIONS} subscriptions."
            raise Refused(text, reply_to=order.id)
        if order.compression != "none":
            text = f"{order.topic} comes as JSON: the compression {order.compression} is not used."
            await client.status("warning", text, order.id)
        if (now := self._lock_step.waiting) is not None:
            await client.publish(now, name)


def _check_reference(topic: str) -> None:
    if resolved(topic) not in {*REFERENCES, JOINT_SPEEDS}:
        raise Refused(f"{topic}: publish on {' or '.join(REFERENCES)}.")


def _service_response(call: CallService) -> dict[str, Any]:
    """Return the answer to a call of one of the services of rosapi, which list the topics."""
    types = {name: topic.type_in(Ros.ONE) for name, topic in TOPICS.items()}
    types |= {RESULT: RESULT_TOPIC.type_in(Ros.ONE)}
    types |= {name: f"geometry_msgs/{kind}" for name, kind in REFERENCES.items()}
    types |= {JOINT_SPEEDS: f"std_msgs/{JOINT_SPEEDS_TYPE}"}
    given = call.args if isinstance(call.args, dict) else {}
    values: Any = {}
    match resolved(call.service):
        case "/rosapi/topics":
            values = {"topics": [*types], "types": [*types.values()]}
        case "/rosapi/topic_type":
            values = {"type": types.get(resolved(str(given.get("topic", ""))), "")}
        case "/rosapi/topics_for_type":
            values = {"topics": [name for name, kind in types.items() if kind == given.get("type")]}
        case _:
            values = f"There is no service {call.service}."
    done = isinstance(values, dict)
    answer = {"op": "service_response", "service": call.service, "values": values, "result": done}
    return answer if call.id is None else answer | {"id": call.id}


@dataclass(frozen=True, slots=True)
class TcpAddress:
    """Where a bridge listens for programs; port 0: one that is free."""

    host: str
    port: int
    origins: Sequence[str] = ()  # whose pages may connect, beside those of this machine

    def url(self, port: int) -> str:
        """Return the address for programs, with the port that was found."""
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"ws://{host}:{port}"


def allowed_origins(address: TcpAddress) -> list[Any]:
    """Return whose connections are accepted, for the WebSocket server."""
    return [None, LOCAL_ORIGIN, *address.origins]  # None: no browser


async def serve_until(
    end: asyncio.Event,
    server: Server,
    address: TcpAddress | Path,
    *,
    listening: Callable[[int], None],
) -> None:
    """Serve clients until `end` is set.

    Parameters
    ----------
    address
        A path is that of a Unix socket.
    listening
        Gets the port; 0 of a Unix socket.

    Raises
    ------
    OSError
        The address cannot be used.
    """
    options: Any = {
        "max_size": LONGEST_MESSAGE,
        "compression": None,
        "close_timeout": CLOSE_WITHIN_S,
    }
    if isinstance(address, Path):
        starting: Any = unix_serve(server.handle, str(address), **options)
    else:
        options["origins"] = allowed_origins(address)
        starting = serve(server.handle, address.host, address.port, **options)
    async with starting as running:
        name = next(iter(running.sockets)).getsockname()
        listening(0 if isinstance(name, str) else name[1])
        await end.wait()
