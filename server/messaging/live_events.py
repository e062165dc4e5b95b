"""Live events: a Redis stream per run, and one reader thread per web process.

Streams and not pub/sub: the id of an entry is the browser's Last-Event-ID, so a page that lost its
connection continues where it stopped.
"""

import json
import queue
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import structlog
from redis import Redis
from redis.exceptions import RedisError

ENTRIES_MAX = 2000  # of a stream; older ones are dropped
EXPIRE_S = 3600  # after the end
BACKLOG = 500  # events that may wait for one slow client; the oldest are dropped
HEARTBEAT_S = 10.0  # proxies close idle connections; only a write detects a lost client
_BLOCK_MS = 200  # the reader follows a new run after this time at the latest
_RETRY_S = 1.0
STATE, TELEMETRY, LOG, END, HEARTBEAT = "state", "telemetry", "log", "end", "heartbeat"
_TYPE_FIELD = "kind"  # as in streams of earlier versions, which outlive a restart
_log = structlog.get_logger()


class TooManyStreams(Exception):
    """The process has as many open streams as it may: answer 503 with Retry-After."""


@dataclass(frozen=True, slots=True)
class Event:
    """One event of a run; a heartbeat has no id and no data."""

    id: str
    type: str  # one of the five above
    data: dict[str, Any]

    def sse(self) -> str:
        """Return the event in the format of text/event-stream."""
        if self.type == HEARTBEAT:
            return ": heartbeat\n\n"
        return f"id: {self.id}\nevent: {self.type}\ndata: {json.dumps(self.data)}\n\n"


def key(run_id: int) -> str:
    """Return the name of a run's stream."""
    return f"run:{run_id}"


def append(redis: "Redis", run_id: int, event_type: str, data: dict[str, Any]) -> None:
    """Add an event; the stream expires an hour after "end". Raises RedisError."""
    fields: Any = {_TYPE_FIELD: event_type, "data": json.dumps(data, allow_nan=False)}
    redis.xadd(key(run_id), fields, maxlen=ENTRIES_MAX, approximate=True)
    if event_type == END:
        redis.expire(key(run_id), EXPIRE_S)


def publish_state(
    redis: "Redis", run_id: int, state: str, *, progress: float = 0.0, t_simulated: float = 0.0
) -> None:
    """Publish the state of a run that is not queued, or that has lost its progress."""
    data = {"state": str(state), "progress": progress, "t_simulated": t_simulated}
    append(redis, run_id, STATE, data | {"position": None})


def publish_end(redis: "Redis", run_id: int, state: str) -> None:
    """Publish the final state of a run that no worker has, and end its streams."""
    publish_state(redis, run_id, state)
    append(redis, run_id, END, {})


def history(redis: "Redis", run_id: int, after: str | None = None) -> list[Event]:
    """Return the events that are kept, those after an id if it is valid; [] without a broker."""
    start = f"({after}" if after is not None and _is_id(after) else "-"
    try:
        entries: Any = redis.xrange(key(run_id), min=start)
    except RedisError as error:
        _log.warning("history_failed", run=run_id, error=str(error))
        return []
    return [_event(entry_id, fields) for entry_id, fields in entries]


class Fanout:
    """Distributes the events of runs to any number of clients over one connection to the broker."""

    def __init__(self, redis: "Redis", *, streams_max: int = 200) -> None:
        self._redis = redis
        self._streams_max = streams_max
        self._clients: dict[int, list[queue.Queue[Event]]] = {}
        self._positions: dict[int, str] = {}
        self._changed = threading.Condition()
        self._thread: threading.Thread | None = None
        self._closed = False

    @property
    def open_streams(self) -> int:
        """The number of connected clients."""
        with self._changed:
            return sum(len(clients) for clients in self._clients.values())

    def subscribe(self, run_id: int, last_id: str | None = None) -> Iterator[Event]:
        """Return the events after `last_id` (all that are kept, if None), then new ones.

        Ends after "end"; yields heartbeats while nothing happens. Raises TooManyStreams at once,
        not when it is first iterated.
        """
        inbox: queue.Queue[Event] = queue.Queue(BACKLOG)
        self._add_client(run_id, inbox)
        return self._events(run_id, inbox, last_id or "0-0")

    def close(self) -> None:
        """Stop the reader and end all streams."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()
        if self._thread is not None:
            self._thread.join()

    def _events(self, run_id: int, inbox: "queue.Queue[Event]", last_id: str) -> Iterator[Event]:
        try:
            # The client is already registered, so no event is lost between history and inbox.
            for event in history(self._redis, run_id, last_id):
                last_id = event.id
                yield event
                if event.type == END:
                    return
            while not self._closed:
                event = _next(inbox)
                if event.type != HEARTBEAT and not _is_later(event.id, last_id):
                    continue
                last_id = event.id or last_id
                yield event
                if event.type == END:
                    return
        finally:
            self._remove_client(run_id, inbox)

    def _add_client(self, run_id: int, inbox: "queue.Queue[Event]") -> None:
        with self._changed:
            if sum(len(clients) for clients in self._clients.values()) >= self._streams_max:
                raise TooManyStreams
            if run_id not in self._clients:
                self._clients[run_id] = []
                self._positions[run_id] = f"{int(time.time() * 1000) - 5000}-0"
            self._clients[run_id].append(inbox)
            if self._thread is None:  # not earlier: threads do not survive gunicorn's fork
                self._thread = threading.Thread(target=self._read, name="fanout", daemon=True)
                self._thread.start()
            self._changed.notify_all()

    def _remove_client(self, run_id: int, inbox: "queue.Queue[Event]") -> None:
        with self._changed:
            clients = self._clients.get(run_id, [])
            if inbox in clients:
                clients.remove(inbox)
            if not clients:
                self._clients.pop(run_id, None)
                self._positions.pop(run_id, None)

    def _read(self) -> None:
        while not self._closed:
            with self._changed:
                while not self._positions and not self._closed:
                    self._changed.wait()
                wanted: Any = {key(run_id): last for run_id, last in self._positions.items()}
            if not wanted:
                continue
            try:
                found: Any = self._redis.xread(wanted, count=200, block=_BLOCK_MS)
            except RedisError as error:
                _log.warning("fanout_read_failed", error=str(error))
                time.sleep(_RETRY_S)
                continue
            self._distribute(found)

    def _distribute(self, found: Any) -> None:
        pairs = found.items() if isinstance(found, dict) else found or []
        for name, entries in pairs:
            run_id = int(name.decode().removeprefix("run:"))
            for entry_id, fields in entries:
                event = _event(entry_id, fields)
                with self._changed:
                    if run_id in self._positions:
                        self._positions[run_id] = event.id
                    for inbox in self._clients.get(run_id, []):
                        _put(inbox, event)


def _event(entry_id: bytes, fields: dict[bytes, bytes]) -> Event:
    event_type = fields[_TYPE_FIELD.encode()].decode()
    return Event(entry_id.decode(), event_type, json.loads(fields[b"data"]))


def _next(inbox: "queue.Queue[Event]") -> Event:
    try:
        return inbox.get(timeout=HEARTBEAT_S)
    except queue.Empty:
        return Event("", HEARTBEAT, {})


def _put(inbox: "queue.Queue[Event]", event: Event) -> None:
    """Put an event; a client that is too slow loses the oldest events."""
    while True:
        try:
            inbox.put_nowait(event)
            return
        except queue.Full:
            try:
                inbox.get_nowait()
            except queue.Empty:
                continue


def _is_id(text: str) -> bool:
    """Return whether this is the id of an entry; Last-Event-ID may hold anything."""
    parts = text.split("-")
    return len(parts) == 2 and all(part.isdecimal() and len(part) < 20 for part in parts)


def _is_later(entry_id: str, last_id: str) -> bool:
    return _numbers(entry_id) > _numbers(last_id)


def _numbers(entry_id: str) -> tuple[int, int]:
    if not _is_id(entry_id):
        return 0, 0
    milliseconds, _, sequence = entry_id.partition("-")
    return int(milliseconds), int(sequence)
