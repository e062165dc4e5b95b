"""What parsing a stranger's bytes costs in a web process.

Each parser gets the worst input that is known for it, as long as a stranger may send it, and as a
reference a small one. CPU times of whole requests, since a parser is never alone. What is parsed
in a process with limits of its own is not here (docs/security.md).
"""

import json
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import h11
from flask import Flask
from flask.testing import FlaskClient
from websockets.protocol import State as SocketState
from websockets.server import ServerProtocol

from performance.tables import aligned
from seamark.embedded.connections import READ_BYTES
from seamark.server.accounts import accounts
from seamark.server.app import create_app
from seamark.server.database.engine import Database
from seamark.server.database.schema import upgrade
from seamark.server.programs.source_differences import differences
from seamark.server.settings import Settings
from seamark.server.web import rate_limits
from seamark.server.web.body_limits import FIELD_MAX, FORM_MAX_BYTES, JSON_MAX_BYTES
from tests.hostile.web.test_work import HEADS
from tests.services import valkey

KIB16 = 16 * 1024
SMALL = 64  # [byte] of the reference
REPEATS = 5
COLUMNS = ("parser", "worst input", "bytes", "ms", "ms small", "us a KiB")
RUNS, LOGS, SWEEPS = "/api/v1/runs", "/api/v1/logs", "/api/v1/sweeps"
FORM, RUN_LIST = "/submit/currents-v1", "/api/v1/leaderboards/currents-v1"
URL_ENCODED, MULTIPART = "application/x-www-form-urlencoded", "multipart/form-data; boundary=b"
Options = dict[str, Any]
Made = tuple[str, Options]


def _repeated(part: str, size: int) -> str:
    return (part * (size // len(part) + 1))[:size]


def _json(start: str, part: str, end: str) -> Callable[[int], Made]:
    """Return the maker of JSON texts with a part that is repeated."""

    def made(size: int) -> Made:
        count = max((size - len(start) - len(end)) // len(part), 0)
        return RUNS, {"data": start + part * count + end, "content_type": "application/json"}

    return made


def _config(entry: Callable[[int], tuple[str, object]], most: int) -> Callable[[int], Made]:
    """Return the maker of configurations whose entries have a number and a length."""

    def made(size: int) -> Made:
        number = min(most, max(size // 40, 1))
        config = dict(entry(size // number) for _ in range(1))
        config = {f"{name}{at}": value for at in range(number) for name, value in config.items()}
        text = json.dumps({"benchmark": "currents-v1", "controller": "pi", "config": config})
        return RUNS, {"data": text, "content_type": "application/json"}

    return made


def _field(path: str, name: str, part: str) -> Callable[[int], Made]:
    """Return the maker of a form with one long field."""
    head = f'--b\r\nContent-Disposition: form-data; name="{name}"\r\n\r\n'
    return lambda size: (
        path,
        {"data": f"{head}{_repeated(part, size)}\r\n--b--\r\n", "content_type": MULTIPART},
    )


def _mapping(part: str) -> Callable[[int], Made]:
    """Return the maker of a log with a long mapping."""
    head = '--b\r\nContent-Disposition: form-data; name="'
    log = f'{head}log"; filename="log.csv"\r\n\r\nt\n0\r\n'
    return lambda size: (
        LOGS,
        {
            "data": f'{log}{head}mapping"\r\n\r\n{_repeated(part, size)}\r\n--b--\r\n',
            "content_type": MULTIPART,
        },
    )


def _encoded(path: str, part: str) -> Callable[[int], Made]:
    return lambda size: (path, {"data": _repeated(part, size), "content_type": URL_ENCODED})


def _parts(size: int) -> Made:
    part = '--b\r\nContent-Disposition: form-data; name="a"\r\n\r\n1\r\n'
    return FORM, {"data": _repeated(part, size), "content_type": MULTIPART}


def _query(start: str, part: str) -> Callable[[int], Made]:
    return lambda size: (start + _repeated(part, size), {})


QUERIES: dict[tuple[str, str], Callable[[int], Made]] = {
    ("search", "words"): _query("/docs/search?q=", "a+"),
    ("search", "letters"): _query("/docs/search?q=", "a"),
    ("settings in an address", "brackets"): _query(
        "/api/v1/rosbridge?benchmark=currents-v1&config=", "["
    ),
    ("settings in an address", "digits"): _query(
        "/api/v1/rosbridge?benchmark=currents-v1&config={%22kp%22:", "9"
    ),
    ("runs to compare", "numbers"): _query("/api/v1/compare?runs=", "1,"),
    ("runs to compare", "a number"): _query("/compare?runs=", "9"),
}


def _compared(first: Callable[[int], int], second: Callable[[int], int]) -> Callable[[int], object]:
    """Return a call that compares two programs of a size; each line has a number by its place."""

    def compare(size: int) -> object:
        places = range(size // len(LINE % 0))
        one, other = (b"".join(LINE % of(at) for at in places) for of in (first, second))
        return differences({"a.py": b"1\n" + one + b"1"}, {"a.py": b"2\n" + other + b"2"})

    return compare


LINE = b"%08d\n"  # 16 KiB are somewhat fewer lines than are compared
PROGRAMS: dict[tuple[str, str], Callable[[int], object]] = {
    ("differences of programs", "equal lines"): _compared(lambda _: 0, lambda _: 0),
    ("differences of programs", "lines that come again"): _compared(
        lambda at: at % 500, lambda at: -at % 499
    ),
    ("differences of programs", "lines in another order"): _compared(
        lambda at: at, lambda at: 1819 - at
    ),
}


RUN = '{"benchmark":"currents-v1","controller":"pi",'
BODIES: dict[tuple[str, str], tuple[Callable[[int], Made], int]] = {
    ("JSON", "opening brackets"): (_json("", "[", ""), JSON_MAX_BYTES),
    ("JSON", "objects in objects"): (_json("", '{"a":', ""), JSON_MAX_BYTES),
    ("JSON", "a number of digits"): (_json('{"seed":', "9", "}"), JSON_MAX_BYTES),
    ("JSON", "a fraction of digits"): (_json('{"seed":0.', "9", "}"), JSON_MAX_BYTES),
    ("JSON", "escapes"): (_json('{"title":"', "\\ud83d\\ude00", '"}'), JSON_MAX_BYTES),
    ("JSON, pydantic", "unknown members"): (
        lambda size: (RUNS, {"json": {f"k{at}": 1 for at in range(size // 9)}}),
        JSON_MAX_BYTES,
    ),
    ("JSON, pydantic", "tags"): (_json(RUN + '"tags":[', '"a",', '"b"]}'), JSON_MAX_BYTES),
    ("configuration", "long unknown settings"): (
        _config(lambda length: ("level_duration_" * (length // 15), 1), 200),
        JSON_MAX_BYTES,
    ),
    ("configuration", "short unknown settings"): (
        _config(lambda _: ("level_duration", 1), 200),
        JSON_MAX_BYTES,
    ),
    ("configuration", "levels"): (
        _json(RUN + '"config":{"levels":[', "0.1,", "0.1]}}"),
        JSON_MAX_BYTES,
    ),
    ("configuration", "levels as a text"): (
        _json(RUN + '"config":{"levels":"', "0,", '"}}'),
        JSON_MAX_BYTES,
    ),
    ("expression of a score", "brackets"): (
        _json(RUN + '"config":{"score":"', "(", '"}}'),
        JSON_MAX_BYTES,
    ),
    ("expression of a score", "signs"): (
        _json(RUN + '"config":{"score":"', "-", '1"}}'),
        JSON_MAX_BYTES,
    ),
    ("expression of a score", "f-strings"): (
        _json(RUN + '"config":{"score":"f\'', "{1}", "'\"}}"),
        JSON_MAX_BYTES,
    ),
    ("expression of a score", "sums"): (
        _json(RUN + '"config":{"score":"', "1+", '1"}}'),
        JSON_MAX_BYTES,
    ),
    ("axes of a sweep", "values"): (
        lambda size: (SWEEPS, {"json": {"run": {}, "axes": {"kp": "0," * (size // 2)}}}),
        JSON_MAX_BYTES,
    ),
    ("URL-encoded form", "fields"): (_encoded(FORM, "a&"), FORM_MAX_BYTES),
    ("URL-encoded form", "escapes"): (_encoded(FORM, "%41"), FORM_MAX_BYTES),
    ("URL-encoded form", "fields of a sign-in"): (_encoded("/sign-in", "&a="), FORM_MAX_BYTES),
    ("multipart form", "parts"): (_parts, FORM_MAX_BYTES),
    ("multipart form", "starts of delimiters"): (_field(FORM, "a", "\r\n--"), FORM_MAX_BYTES),
    ("multipart form", "headers"): (
        lambda size: (
            FORM,
            {"data": "--b\r\n" + _repeated("X: y\r\n", size), "content_type": MULTIPART},
        ),
        FORM_MAX_BYTES,
    ),
    ("mapping of a log", "a dotted key"): (_mapping("a."), FIELD_MAX),
    ("mapping of a log", "brackets"): (_mapping("a=[["), FIELD_MAX),
    ("field of a form", "digits"): (_field(FORM, "kp", "9"), FIELD_MAX),
    ("field of a form", "levels"): (_field(FORM, "levels", "0,"), FIELD_MAX),
    ("password", "letters"): (_field("/sign-in", "password", "b"), FIELD_MAX),
    ("address of mail", "letters and dots"): (_field("/account/mail", "mail", "a@a."), FIELD_MAX),
}


def _http(part: bytes) -> Callable[[int], None]:
    """Return a call that parses HTTP as the event loop does, as much as is read at once."""

    def parse(size: int) -> None:
        connection = h11.Connection(h11.SERVER)
        head = b"POST / HTTP/1.1\r\nHost: a\r\nTransfer-Encoding: chunked\r\n\r\n"
        connection.receive_data(head + part * (size // len(part)))
        while connection.next_event() is not h11.NEED_DATA:
            pass

    return parse


def _head(part: bytes) -> Callable[[int], None]:
    def parse(size: int) -> None:
        connection = h11.Connection(h11.SERVER)
        lines = part * ((size - 40) // len(part))
        connection.receive_data(b"GET / HTTP/1.1\r\nHost: a\r\n" + lines + b"\r\n")
        connection.next_event()

    return parse


def _bytewise(size: int) -> None:
    connection = h11.Connection(h11.SERVER)
    connection.receive_data(b"GET / HTTP/1.1\r\nX: ")
    for _ in range(size - 40):
        connection.receive_data(b"x")
        connection.next_event()


def _frames(frame: bytes) -> Callable[[int], None]:
    def parse(size: int) -> None:
        protocol = ServerProtocol(state=SocketState.OPEN, max_size=64 * 1024)
        protocol.receive_data(frame * (size // len(frame)))
        protocol.events_received()
        protocol.data_to_send()

    return parse


MASK = bytes(4)
WIRE: dict[tuple[str, str], Callable[[int], None]] = {
    ("HTTP", "chunks of a byte"): _http(b"1\r\nx\r\n"),
    ("HTTP", "chunks with extensions"): _http(b"1;a=b\r\nx\r\n"),
    ("HTTP", "headers"): _head(b"a:b\r\n"),
    ("HTTP", "folded headers"): _head(b" b\r\n"),
    ("HTTP", "a header of spaces"): _head(b"a:" + b" " * 16_000 + b"x\r\n"),
    ("HTTP", "a head byte by byte"): _bytewise,
    ("WebSocket", "pings"): _frames(b"\x89\x80" + MASK),
    ("WebSocket", "empty messages"): _frames(b"\x81\x80" + MASK),
    ("WebSocket", "a message in pieces"): _frames(b"\x01\x80" + MASK + (b"\x00\x80" + MASK) * 900),
}


def _least_ms(call: Callable[[], object]) -> float:
    times = []
    for _ in range(REPEATS):
        began = time.process_time()
        call()
        times.append(time.process_time() - began)
    return 1e3 * min(times)


@contextmanager
def _application() -> Iterator[tuple[Flask, dict[str, str]]]:
    """Give the application and the headers of a user's request."""
    with tempfile.TemporaryDirectory() as folder, valkey.on_socket() as broker:
        values = {"data": Path(folder), "broker_url": broker, "secret_key": "only-for-this"}
        settings = Settings.model_validate(values)
        upgrade(settings)
        database = Database(settings.database_url)
        with database.writing() as session:
            user = accounts.sign_up(session, "ann", None)
            token = accounts.new_token(session, user.id, "performance", ("read", "submit"))
        database.close()
        app = create_app(settings)
        app.config.update(WTF_CSRF_METHODS=[])
        rate_limits.limiter.enabled = False
        try:
            yield app, {"Authorization": f"Bearer {token}"}
        finally:
            app.extensions["seamark"].close()


def _sent_ms(client: FlaskClient, method: str, headers: dict[str, str], made: Made) -> float:
    path, options = made
    options = options | {"headers": headers | options.get("headers", {})}

    def send() -> None:
        with client.open(path.replace("{run}", "1"), method=method, **options) as answer:
            answer.get_data()

    return _least_ms(send)


def _row(names: tuple[str, str], size: int, worst_ms: float, small_ms: float) -> tuple[str, ...]:
    by_kib = 1e3 * max(worst_ms - small_ms, 0.0) / (size / 1024)
    return (*names, str(size), f"{worst_ms:.1f}", f"{small_ms:.1f}", f"{by_kib:.0f}")


def _rows() -> Iterator[tuple[str, ...]]:
    for names, parse in WIRE.items():
        small = _least_ms(partial(parse, SMALL))
        yield _row(names, READ_BYTES, _least_ms(partial(parse, READ_BYTES)), small)
    for names, compare in PROGRAMS.items():
        small = _least_ms(partial(compare, SMALL))
        yield _row(names, KIB16, _least_ms(partial(compare, KIB16)), small)
    with _application() as (app, headers):
        client = app.test_client()
        for names, query in QUERIES.items():
            small = _sent_ms(client, "GET", headers, query(SMALL))
            yield _row(names, KIB16, _sent_ms(client, "GET", headers, query(KIB16)), small)
        for name, head in HEADS.items():
            small = _sent_ms(client, "GET", headers, head(SMALL))
            yield _row(("head", name), KIB16, _sent_ms(client, "GET", headers, head(KIB16)), small)
        for names, (made, limit) in BODIES.items():
            small = _sent_ms(client, "POST", headers, made(SMALL))
            for size in sorted({KIB16, limit}):
                yield _row(names, size, _sent_ms(client, "POST", headers, made(size)), small)


def table() -> str:
    """Return the table."""
    return aligned([COLUMNS, *_rows()])
