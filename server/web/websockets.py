"""WebSockets: the application decides about the handshake as about any request.

It answers with 101 and puts a `Conversation` into the WSGI environment, which then goes on on the
event loop; any other answer refuses the handshake.
"""

from __future__ import annotations

import asyncio
import json
from collections.abc import Awaitable, Callable, Mapping
from http import HTTPStatus
from typing import Any, Protocol

from seamark.server.web.problems import MEDIA_TYPE, Problem

UPGRADE = "seamark.upgrade"  # key of the WSGI environment: the client asks for a WebSocket
CONVERSATION = "seamark.conversation"  # key of the WSGI environment
SEND_S = 20.0  # that a client may take for a message
NORMAL, POLICY_VIOLATION, INTERNAL_ERROR = 1000, 1008, 1011  # close codes of RFC 6455, 7.4.1

Receive = Callable[[], Awaitable[dict[str, Any]]]
Send = Callable[[dict[str, Any]], Awaitable[None]]


class NotAllowed(Exception):
    """Whoever converses may do so no longer. The text is for them."""


class WebSocket:
    """A connection with text messages."""

    def __init__(self, receive: Receive, send: Send, abort: Callable[[], None]) -> None:
        self._receive, self._send, self._abort = receive, send, abort

    async def receive(self) -> str | None:
        """Return the next message; None when the client is gone, or sends what is no text."""
        while True:
            message = await self._receive()
            if message["type"] == "websocket.connect":
                continue
            text: str | None = message.get("text")
            return text

    async def send(self, text: str) -> None:
        """Send a message.

        Raises
        ------
        ConnectionError
            The client did not take it in time, and is disconnected.
        """
        try:
            async with asyncio.timeout(SEND_S):
                await self._send({"type": "websocket.send", "text": text})
        except TimeoutError:
            self._abort()
            raise ConnectionError("the client takes no messages") from None


class Conversation(Protocol):
    """What follows a handshake."""

    async def begin(self) -> Mapping[str, str]:
        """Prepare, and return headers of the answer; raises Problem to refuse the handshake."""

    async def run(self, socket: WebSocket) -> str:
        """Converse until the end; return what went wrong, empty if nothing did.

        Raises
        ------
        NotAllowed
        """

    async def end(self) -> None:
        """Release what `begin` has prepared; called whatever happened."""


async def converse(conversation: Conversation, socket: WebSocket, send: Send) -> None:
    """Accept a handshake and carry out the conversation, or refuse it."""
    try:
        headers = await conversation.begin()
        await send({"type": "websocket.accept", "headers": _encoded(headers)})
        wrong = await conversation.run(socket)
        code = INTERNAL_ERROR if wrong else NORMAL
        await send({"type": "websocket.close", "code": code, "reason": wrong})
    except NotAllowed as reason:
        await send({"type": "websocket.close", "code": POLICY_VIOLATION, "reason": str(reason)})
    except Problem as problem:
        await _refuse_with(problem, send)
    except OSError:
        pass  # the client is gone
    finally:
        await conversation.end()


async def refuse(head: Mapping[str, Any], body: bytes, send: Send) -> None:
    """Answer a handshake as the application has refused the request, or that it is for others."""
    if head["status"] < HTTPStatus.BAD_REQUEST:
        await _refuse_with(Problem("not-found", "There is no WebSocket at this address."), send)
        return
    await _answer(head, body, send)


async def _answer(head: Mapping[str, Any], body: bytes, send: Send) -> None:
    start = {"status": head["status"], "headers": head["headers"]}
    await send({"type": "websocket.http.response.start"} | start)
    await send({"type": "websocket.http.response.body", "body": body})


async def _refuse_with(problem: Problem, send: Send) -> None:
    headers = {"Content-Type": MEDIA_TYPE, "Cache-Control": "no-store"} | problem.headers
    head = {"status": problem.type.status, "headers": _encoded(headers)}
    await _answer(head, json.dumps(problem.document()).encode(), send)


def _encoded(headers: Mapping[str, str]) -> list[tuple[bytes, bytes]]:
    return [(name.lower().encode(), value.encode("latin-1")) for name, value in headers.items()]
