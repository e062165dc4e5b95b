"""Who gives way when there are too many connections."""

import asyncio
import socket
from collections.abc import Callable, Iterable, Mapping
from contextlib import ExitStack, suppress
from typing import Any, cast

import pytest

from seamark.embedded.connections import CONNECTIONS, WAITING_OF_ADDRESS, Connections, State
from seamark.server.classes.classrooms import PUPILS_MAX
from seamark.server.web.websockets import CONVERSATION, UPGRADE, WebSocket
from tests.services.asgi import answer_of, serving

HANDSHAKE = (
    b"GET / HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
)
GET = b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n"


class FakeTransport:
    """A connection that remembers whether it was ended."""

    def __init__(self, name: str) -> None:
        self.name, self.aborted = name, False

    def abort(self) -> None:
        self.aborted = True


class Crowd:
    """Connections with names."""

    def __init__(self, most: int, waiting_max: int) -> None:
        self.connections = Connections(most, waiting_max)
        self._all: dict[str, FakeTransport] = {}

    def wait(self, name: str, address: str) -> None:
        self.connections.wait(self._transport(name), address)

    def answer(self, name: str, address: str) -> None:
        self.connections.answer(self._transport(name), address)

    def leave(self, name: str) -> None:
        self.connections.leave(self._transport(name))

    def ended(self) -> set[str]:
        return {name for name, transport in self._all.items() if transport.aborted}

    def _transport(self, name: str) -> asyncio.Transport:
        return cast("asyncio.Transport", self._all.setdefault(name, FakeTransport(name)))


def test_the_one_that_has_waited_longest_gives_way() -> None:
    crowd = Crowd(most=3, waiting_max=9)
    crowd.answer("answered", "a")
    for name in ("first", "second", "third", "fourth"):
        crowd.wait(name, "a")

    assert crowd.ended() == {"first", "second"}
    assert len(crowd.connections) == 3


def test_one_that_was_answered_and_waits_again_has_not_waited_longest() -> None:
    crowd = Crowd(most=2, waiting_max=9)
    crowd.wait("old", "a")
    crowd.wait("other", "a")
    crowd.answer("old", "a")
    crowd.wait("old", "a")
    crowd.wait("new", "a")

    assert crowd.ended() == {"other"}


def test_an_address_pushes_out_its_own_connections_that_wait_and_no_others() -> None:
    crowd = Crowd(most=9, waiting_max=2)
    crowd.wait("slow", "b")
    crowd.answer("answered", "a")
    for number in range(5):
        crowd.wait(f"flood {number}", "a")

    assert crowd.ended() == {"flood 0", "flood 1", "flood 2"}


def test_the_bound_of_an_address_is_not_that_of_a_proxy_whose_clients_are_not_known_yet() -> None:
    crowd = Crowd(most=9, waiting_max=2)
    for number in range(9):
        crowd.wait(f"{number}", "")

    assert crowd.ended() == set()


def test_a_newcomer_takes_a_place_of_the_address_that_has_most_but_not_of_its_own() -> None:
    crowd = Crowd(most=4, waiting_max=9)
    for name, address in (("one", "a"), ("two", "a"), ("three", "a"), ("four", "b")):
        crowd.answer(name, address)
    crowd.wait("of b", "b")
    crowd.answer("of b", "b")
    crowd.wait("of a", "a")

    assert crowd.ended() == {"three", "of a"}


def test_connections_that_have_left_leave_nothing_behind() -> None:
    crowd = Crowd(most=2, waiting_max=1)
    for number in range(10):
        crowd.wait(f"{number}", f"{number % 2}")
        crowd.answer(f"{number}", f"{number % 3}")
        crowd.leave(f"{number}")
        crowd.leave(f"{number}")

    assert crowd.ended() == set()
    assert not any(
        vars(crowd.connections)[name] for name in vars(crowd.connections) if "_of" in name
    )
    assert len(crowd.connections) == 0


def test_a_class_behind_one_address_has_room_for_its_browsers() -> None:
    streams, others = PUPILS_MAX, PUPILS_MAX  # each browser shows one run, and loads a part of it

    assert others <= WAITING_OF_ADDRESS
    assert streams + WAITING_OF_ADDRESS <= CONNECTIONS


@pytest.mark.parametrize(
    ("proxies", "forwarded", "address"),
    [
        (0, b"6.6.6.6", "192.0.2.1/32"),
        (1, b"6.6.6.6, 198.51.100.7", "198.51.100.7/32"),
        (2, b"6.6.6.6, 198.51.100.7, 192.0.2.9", "198.51.100.7/32"),
        (1, b"2001:db8:1:2:3:4:5:6", "2001:db8:1:2::/64"),
        (1, b"::ffff:198.51.100.7", "198.51.100.7/32"),
        (2, b"6.6.6.6", ""),
        (1, b"unknown", ""),
        (1, b"", ""),
    ],
)
def test_the_address_is_that_which_the_trusted_proxies_vouch_for(
    proxies: int, forwarded: bytes, address: str
) -> None:
    state = State(proxies=proxies)

    found = state.address_of(("192.0.2.1", 4242), [(b"x-forwarded-for", forwarded)])

    assert found == address
    assert state.address_of(None) == ""


class _Undecided:
    """A handshake that is never decided."""

    async def begin(self) -> Mapping[str, str]:
        await asyncio.Event().wait()
        raise AssertionError

    async def run(self, socket: WebSocket) -> str:
        raise AssertionError

    async def end(self) -> None: ...


def _application(environ: dict[str, Any], start_response: Any) -> Iterable[bytes]:
    if environ.get(UPGRADE):
        environ[CONVERSATION] = _Undecided()
    start_response("101 Switching Protocols" if environ.get(UPGRADE) else "200 OK", [])
    return []


def _open(stack: ExitStack, connect: Callable[[bytes], socket.socket], request: bytes) -> None:
    with suppress(ConnectionError):  # it may have given way already
        connection = stack.enter_context(connect(request))
        if request == GET:
            connection.recv(1)


@pytest.mark.parametrize("flood", [b"", b"GET / HT", HANDSHAKE, b"POST /", GET], ids=repr)
@pytest.mark.parametrize(("most", "waiting_max"), [(20, 100), (100, 20)], ids=["all", "address"])
def test_a_flood_of_unfinished_requests_keeps_nobody_out(
    flood: bytes, most: int, waiting_max: int
) -> None:
    state = State(Connections(most, waiting_max))
    with serving(_application, state=state) as connect, ExitStack() as stack:
        for _ in range(3):
            for _ in range(50):
                _open(stack, connect, flood)

            assert answer_of(connect(GET))[0].status == 200
        assert len(state.crowd) <= 21


@pytest.mark.slow
def test_at_the_end_of_the_server_handshakes_that_are_not_decided_are_told_to_come_again() -> None:
    with ExitStack() as waiting:
        with serving(_application, forced=False) as connect:
            connections = [waiting.enter_context(connect(HANDSHAKE)) for _ in range(5)]
            assert answer_of(connect(GET))[0].status == 200

        answers = [answer_of(connection)[0] for connection in connections]

    assert [answer.status for answer in answers] == [503] * 5
    assert {answer.headers["Retry-After"] for answer in answers} == {"1"}
