"""The connections of one web process, and which of them give way when there are too many."""

from __future__ import annotations

import asyncio
import resource
from collections import defaultdict
from collections.abc import Iterable

from uvicorn.server import ServerState

from seamark.server.web import address_prefix

CONNECTIONS = 4000  # of one process
# Of them those of one address that wait: for a request, for the rest of one or, after an answer,
# for the next. A class of 700 may share an address; each browser holds up to six connections for
# the seconds between two requests, and one beyond the bound is opened again when it is needed.
WAITING_OF_ADDRESS = CONNECTIONS // 2
READ_BYTES = 16 * 1024  # at once: parsing that much of the worst takes milliseconds

Headers = Iterable[tuple[bytes, bytes]]


class Connections:
    """All connections: those that wait for their client, and those that are being answered.

    Of too many the one goes that has waited longest, for a slow client sends its request within a
    fraction of the deadline. If all are being answered, a newcomer takes the place of one of the
    address that has most, unless that is its own.

    Parameters
    ----------
    most
        Connections that there may be.
    waiting_max
        Connections of one address that may wait.
    """

    def __init__(self, most: int = CONNECTIONS, waiting_max: int = WAITING_OF_ADDRESS) -> None:
        self._most, self._waiting_max = most, waiting_max
        self._addresses: dict[asyncio.Transport, str] = {}
        self._waiting: dict[asyncio.Transport, None] = {}  # the longest first
        self._waiting_of = defaultdict[str, dict[asyncio.Transport, None]](dict)
        self._busy_of = defaultdict[str, dict[asyncio.Transport, None]](dict)

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self._addresses)

    def wait(self, transport: asyncio.Transport, address: str) -> None:
        """Add a connection that waits for its client; an empty address is that of nobody known."""
        self.leave(transport)
        self._addresses[transport] = address
        self._waiting[transport] = self._waiting_of[address][transport] = None
        if address and len(self._waiting_of[address]) > self._waiting_max:
            self._send_away(next(iter(self._waiting_of[address])))
        elif len(self) > self._most:
            self._send_away(self._least_needed(transport))

    def answer(self, transport: asyncio.Transport, address: str) -> None:
        """Let a connection stay whose request is being answered."""
        self.leave(transport)
        self._addresses[transport] = address
        self._busy_of[address][transport] = None

    def leave(self, transport: asyncio.Transport) -> None:
        """Forget a connection, if it is there."""
        address = self._addresses.pop(transport, None)
        if address is None:
            return
        self._waiting.pop(transport, None)
        for group in (self._waiting_of, self._busy_of):
            group[address].pop(transport, None)
            if not group[address]:
                del group[address]

    def _least_needed(self, newcomer: asyncio.Transport) -> asyncio.Transport:
        oldest = next(iter(self._waiting))
        if oldest is not newcomer:
            return oldest
        own = len(self._busy_of.get(self._addresses[newcomer], ()))
        most = max(self._busy_of.values(), key=len)
        return newcomer if own + 1 >= len(most) else next(reversed(most))

    def _send_away(self, transport: asyncio.Transport) -> None:
        self.leave(transport)  # the transport itself tells only later
        transport.abort()


class State(ServerState):
    """What the connections of one web process share.

    Parameters
    ----------
    proxies
        Trusted proxies in a row in front. Then the peer is no client: who it is, a request tells.
    """

    def __init__(self, connections: Connections | None = None, *, proxies: int = 0) -> None:
        super().__init__()
        self.crowd = Connections() if connections is None else connections
        self.read_buffer = bytearray(READ_BYTES)  # emptied before the next connection is read
        self._proxies = proxies

    def address_of(self, client: tuple[str, int] | None, headers: Headers = ()) -> str:
        """Return from where a connection comes; empty if that is not known, or not yet."""
        if not self._proxies:
            return _host(client[0]) if client else ""
        values = [value for name, value in headers if name == b"x-forwarded-for"]
        forwarded = b",".join(values).decode("latin-1").split(",")
        return _host(forwarded[-self._proxies].strip()) if len(forwarded) >= self._proxies else ""


def most_connections() -> int:
    """Return how many there may be; half of the files that may be open are for other things."""
    soft, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    return CONNECTIONS if soft == resource.RLIM_INFINITY else min(CONNECTIONS, soft // 2)


def _host(address: str) -> str:
    try:
        return address_prefix.host(address)
    except ValueError:  # what a proxy sends instead of an address
        return ""
