"""Passes messages on between the broker and the bridge of a simulation, which parses them."""

import threading
import time
from collections import deque
from collections.abc import Sequence
from itertools import islice
from pathlib import Path

import structlog
from redis import Redis
from redis.exceptions import RedisError
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, unix_connect

from seamark.server.messaging import bridge_sessions
from seamark.server.messaging.bridge_sessions import END, PENDING_MAX, RENEW_S, Keys

CONNECT_POLL_S = 0.02
FULL_S = 0.005  # between two looks at a list that is full
PENDING_BYTES = 2**20  # that may wait for the program: images are large, and the broker is small
STALLED_S = 10.0  # that messages may wait for the program
STOP_S = 2.0  # that the end of a run waits for the last messages
_log = structlog.get_logger()


class BridgeRelay:
    """The messages of one session, in threads of its own."""

    def __init__(self, redis: "Redis", session: str, socket: Path) -> None:
        """Set up.

        Parameters
        ----------
        socket
            Where the simulation listens as soon as it has started.
        """
        self._redis, self._session, self._socket = redis, session, socket
        self._keys = Keys(session)
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._relay, name="bridge", daemon=True)

    def start(self) -> None:
        """Pass messages on from now on."""
        threading.Thread(target=self._show_presence, name="presence", daemon=True).start()
        self._thread.start()

    def stop(self) -> None:
        """Let the program know that nothing follows."""
        self._ending.set()
        self._thread.join(STOP_S)
        try:
            bridge_sessions.push(self._redis, self._keys.down, END)
        except RedisError as error:  # its web process finds that by itself
            _log.warning("session_not_ended", error=str(error))

    def _relay(self) -> None:
        connection = self._connected()
        if connection is None:
            return
        with connection:
            up = threading.Thread(target=self._pass_up, args=(connection,), daemon=True)
            up.start()
            try:
                self._pass_down(connection)
            except (ConnectionClosed, RedisError) as error:  # the simulation was stopped; no broker
                _log.info("session_over", why=str(error))
            finally:
                self._ending.set()
        up.join()

    def _show_presence(self) -> None:
        over = False
        while not over:
            try:
                bridge_sessions.serve(self._redis, self._session)
            except RedisError as error:
                _log.warning("session_not_renewed", error=str(error))
            over = self._ending.wait(RENEW_S)

    def _connected(self) -> ClientConnection | None:
        """Return a connection to the simulation; None if the run has ended before."""
        while not self._ending.wait(CONNECT_POLL_S):
            try:
                return unix_connect(str(self._socket), max_size=None, compression=None)
            except (OSError, TimeoutError):  # not yet
                continue
        return None

    def _pass_down(self, connection: ClientConnection) -> None:
        """Send what the simulation publishes, until it closes the connection."""
        sizes = deque[int](maxlen=PENDING_MAX)
        for message in connection:
            item = bridge_sessions.text(str(message))
            waiting = bridge_sessions.push(self._redis, self._keys.down, item)
            sizes.append(len(item))
            until = time.monotonic() + STALLED_S
            while _is_full(sizes, waiting):
                if time.monotonic() > until:
                    return
                time.sleep(FULL_S)
                waiting = bridge_sessions.waiting(self._redis, self._keys.down)

    def _pass_up(self, connection: ClientConnection) -> None:
        """Send the simulation what the program says, until that has gone."""
        try:
            while not self._ending.is_set():
                items = bridge_sessions.read(self._redis, self._keys.up)
                if not items and not bridge_sessions.is_present(self._redis, self._session):
                    break
                for item in items:
                    if item == END:
                        return
                    if (message := bridge_sessions.message_of(item)) is not None:
                        connection.send(message)
        except (ConnectionClosed, RedisError) as error:
            _log.info("session_over", why=str(error))
        finally:
            connection.close()


def _is_full(sizes: Sequence[int], waiting: int) -> bool:
    """Return whether too much waits: the last of the messages with these sizes [byte]."""
    return waiting >= PENDING_MAX or sum(islice(reversed(sizes), waiting)) > PENDING_BYTES
