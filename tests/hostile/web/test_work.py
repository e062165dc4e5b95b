"""Addresses and headers are read in time that grows no faster than their length.

Bodies are in tests/server/api/requests/test_body_limits.py, uploads in
tests/server/programs/test_reader.py.
"""

import gzip
import pkgutil
import re
import time
from collections.abc import Callable
from importlib import import_module
from typing import Any

import pytest

from seamark import server
from tests.server.pages.conftest import Site

SIZE = 30 * 1024  # [B]; the web server accepts heads of 64 KiB
REPEATS = 3
FLOOR_S = 0.05  # less is not measured well
RATIO_MAX = 3.5  # of twice the length: linear gives 2, quadratic 4
ANSWER_MAX = 2**20  # [B]
SEARCH_S = 0.4  # a linear search of 30 KiB takes milliseconds, a quadratic one a second
Head = dict[str, Any]


def _query(path: str, part: str) -> Callable[[int], tuple[str, Head]]:
    return lambda size: (f"{path}?{part * (size // len(part))}", {})


def _header(name: str, part: str, path: str = "/api/v1/benchmarks") -> Callable[[int], Any]:
    return lambda size: (path, {"headers": {name: part * (size // len(part))}})


HEADS: dict[str, Callable[[int], tuple[str, Head]]] = {
    "path": lambda size: ("/" + "a" * size, {}),
    "path of slashes": lambda size: ("/runs" + "/" * size, {}),
    "path of folders": lambda size: ("/docs/guides/" + "a/" * (size // 2), {}),
    "path of dots": lambda size: ("/static/" + "../" * (size // 3), {}),
    "path of escapes": lambda size: ("/docs/guides/" + "%41" * (size // 3), {}),
    "path of bad escapes": lambda size: ("/docs/guides/" + "%" * size, {}),
    "path of digits": lambda size: ("/runs/" + "9" * size, {}),
    "API path of digits": lambda size: ("/api/v1/runs/" + "9" * size, {}),
    "query of names": _query("/runs/", "a&"),
    "query of escapes": _query("/runs/", "%41"),
    "query of states": _query("/api/v1/runs", "state=queued&"),
    "query of wrong states": _query("/api/v1/runs", "state=x&"),
    "query of limits": _query("/api/v1/runs", "limit=1&"),
    "long limit": lambda size: ("/api/v1/runs?limit=" + "9" * size, {}),
    "long cursor": lambda size: ("/leaderboards/currents-v1?after=" + "1," * (size // 2), {}),
    "long cursor of the API": lambda size: (
        "/api/v1/leaderboards/currents-v1?after=" + "1," * (size // 2),
        {},
    ),
    "presets": lambda size: ("/submit/currents-v1?levels=" + "0," * (size // 2), {}),
    "return address": lambda size: ("/sign-in?next=" + "/" * size, {}),
    "return address with ports": lambda size: ("/sign-in?next=/" + "@:[" * (size // 3), {}),
    "columns": lambda size: ("/api/v1/runs/{run}/series.json?columns=" + "t," * (size // 2), {}),
    "position": lambda size: ("/api/v1/runs/{run}/events?after=" + "9-" * (size // 2), {}),
    "Accept": _header("Accept", "a/b;q=0.1,"),
    "Accept of a page": _header("Accept", "text/*;q=0.1,", "/nothing"),
    "Accept with parameters": _header("Accept", 'a/b;c="\\"";', "/nothing"),
    "Accept of ranks": _header("Accept", "text/csv;q=1,", "/api/v1/leaderboards/currents-v1"),
    "Accept-Language": _header("Accept-Language", "en-GB;q=0.1,", "/"),
    "Cookie": _header("Cookie", "a=b; ", "/"),
    "Cookie of quotes": _header("Cookie", 'a="\\073";', "/"),
    "session": lambda size: ("/", {"headers": {"Cookie": "seamark=." + "eJ" * (size // 2)}}),
    "session of dots": lambda size: ("/", {"headers": {"Cookie": "seamark=" + "." * size}}),
    "token": _header("Authorization", "Bearer "),
    "basic credentials": lambda size: ("/", {"headers": {"Authorization": "Basic " + "a" * size}}),
    "If-None-Match": _header("If-None-Match", '"a", ', "/static/logo.svg"),
    "If-None-Match of a run": _header("If-None-Match", 'W/"a",', "/api/v1/runs/{run}"),
    "If-Modified-Since": _header("If-Modified-Since", "Mon, ", "/static/logo.svg"),
    "Range": _header("Range", "bytes=0-1,", "/static/logo.svg"),
    "Last-Event-ID": _header("Last-Event-ID", "9-", "/api/v1/runs/{run}/events"),
    "X-Forwarded-For": _header("X-Forwarded-For", "1.2.3.4, ", "/"),
    "Host": _header("Host", "a.", "/"),
    "Content-Type": _header("Content-Type", 'a/b;c="d";', "/"),
}


def _cpu_s(site: Site, head: tuple[str, Head], run_id: int) -> float:
    """Return the least CPU time of a request, which the other work of a machine does not change."""
    path, options = head
    client, times = site.app.test_client(), []
    for _ in range(REPEATS):
        begin = time.process_time()
        with client.get(path.replace("{run}", str(run_id)), **options) as answer:
            times.append(time.process_time() - begin)
            assert answer.status_code < 500
            assert len(answer.get_data()) < ANSWER_MAX
    return min(times)


@pytest.fixture
def run_id(site: Site) -> int:
    return site.published("ann", kind="ranked")


@pytest.mark.slow
def test_a_head_of_twice_the_length_takes_at_most_twice_the_time(site: Site, run_id: int) -> None:
    slow = {}
    for name, head in HEADS.items():
        single, double = (_cpu_s(site, head(size), run_id) for size in (SIZE, 2 * SIZE))
        if double > RATIO_MAX * max(single, FLOOR_S):
            slow[name] = (single, double)

    assert slow == {}


def test_a_compressed_body_is_not_unpacked(site: Site) -> None:
    bomb = gzip.compress(b" " * 2**26, compresslevel=1)[: 64 * 1024]
    browser = site.browser("ann")
    headers = {"Content-Encoding": "gzip", "X-CSRFToken": browser.csrf_token()}
    begin = time.process_time()

    for kind in ("application/json", "application/x-www-form-urlencoded"):
        answer = browser.client.post("/api/v1/runs", data=bomb, content_type=kind, headers=headers)
        assert 400 <= answer.status_code < 500

    assert time.process_time() - begin < 1.0


PUMPS = (
    *(" ", "\t", "\n", "a", "0", "-", ".", ",", ":", "(", ")", "<", '"', "/", "\\"),
    *("a.", "0,", "a ", " (line 1 of ", "a:1:1: error: ", "aux.", "a b "),
)


def _patterns() -> dict[str, "re.Pattern[str]"]:
    """Return all regular expressions of the server."""
    modules = [
        import_module(info.name)
        for info in pkgutil.walk_packages(server.__path__, "seamark.server.")
        if info.name != "seamark.server.pages.docs.guides"  # reads our own documentation alone
    ]
    return {
        f"{module.__name__}.{name}": value
        for module in modules
        for name, value in vars(module).items()
        if isinstance(value, re.Pattern)
    }


def _search_s(pattern: "re.Pattern[str]", text: str) -> float:
    searched = text.encode() if isinstance(pattern.pattern, bytes) else text
    begin = time.process_time()
    pattern.search(searched)
    pattern.fullmatch(searched)
    return time.process_time() - begin


def test_no_regular_expression_of_the_server_takes_long_for_any_repetition() -> None:
    patterns = _patterns()
    assert len(patterns) > 5

    slow = {
        (name, pump)
        for name, pattern in patterns.items()
        for pump in PUMPS
        for end in ("", "!")
        if _search_s(pattern, pump * (SIZE // len(pump)) + end) > SEARCH_S
    }

    assert slow == set()
