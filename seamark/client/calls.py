"""The calls of the API as generators, for both clients (`seamark.client.exchange`)."""

from __future__ import annotations

import json
import secrets
from collections.abc import Mapping, Sequence
from datetime import date, time
from pathlib import Path
from typing import Any, BinaryIO, Final, cast
from urllib.parse import quote

import httpx

from seamark.client import exchange
from seamark.client.documents import (
    BenchmarkDocument,
    ComparisonDocument,
    LeaderboardDocument,
    RunDocument,
    SubmissionOptions,
    SweepDocument,
    Values,
)
from seamark.client.errors import ServerRefused
from seamark.client.exchange import Call, Request
from seamark.formats.registry import FORMATS

API: Final = "/api/v1"
PAGE_MAX = 200  # runs, the largest page of the API
# Without these an answer is not that of a Seamark server; a newer or older one may have others.
RUN_KEYS = (
    "id",
    "benchmark",
    "title",
    "state",
    "progress",
    "position",
    "public",
    "result",
    "failure",
    "links",
)
_FILES = ("program", "vehicle", "tracker_program", "detector_program")  # of a submission
_JSON = "application/json"
FIRST_ANSWER_S = 4.0  # of pauses until an address that has never answered is given up
COMPETITION_KEYS = (
    *("name", "title", "question", "benchmark", "zone", "state", "teams", "own_team"),
    *("rounds", "document", "digest", "links"),
)
BOARD_KEYS = ("round", "hidden", "rows", "reference_entries")
SWEEP_KEYS = ("id", "live", "best", "cells", "links")


class Calls:
    """The calls of one server.

    Parameters
    ----------
    server
        Its address.
    signed_in
        Whether requests carry a token. Without one the server knows nobody, so that it cannot
        recognise a submission that is repeated.
    patience_s
        How long the pauses between the attempts of one request may last in total.
    """

    def __init__(self, server: str, *, signed_in: bool, patience_s: float) -> None:
        self.server = server
        self._signed_in = signed_in
        self._patience_s = patience_s
        self._has_answered = False

    def send(self, method: str, path: str, **options: Any) -> Call[httpx.Response]:
        """Return the response to a request below /api/v1."""
        request = Request(method, API + path, options)
        return self._exchange(request)

    def _exchange(self, request: Request) -> Call[httpx.Response]:
        # An address that never answered is likely to be wrong; a known server may be restarting.
        reach_s = self._patience_s if self._has_answered else FIRST_ANSWER_S
        attempts = exchange.exchange(
            self.server, request, patience_s=self._patience_s, reach_s=reach_s
        )
        try:
            response = yield from attempts
        except ServerRefused:
            self._has_answered = True
            raise
        self._has_answered = True
        return response

    def document(
        self, method: str, path: str, *, needs: Sequence[str] = (), **options: Any
    ) -> Call[Any]:
        """Return the JSON object that answers a request below /api/v1."""
        response = yield from self.send(method, path, **options)
        return exchange.document(self.server, response, needs)

    def submit(self, benchmark: str, options: SubmissionOptions) -> Call[RunDocument]:
        """Submit a run."""
        return self._post_run("/runs", benchmark, options, needs=RUN_KEYS)

    def sweep(
        self, benchmark: str, axes: Mapping[str, Values], options: SubmissionOptions
    ) -> Call[SweepDocument]:
        """Start a sweep."""
        swept = [
            {"name": name, "values": values if isinstance(values, str) else list(values)}
            for name, values in axes.items()
        ]
        return self._post_run("/sweeps", benchmark, options, needs=SWEEP_KEYS, sweep=swept)

    def run(self, run_id: int) -> Call[RunDocument]:
        """Return a run in its present state."""
        return self.document("GET", f"/runs/{run_id}", needs=RUN_KEYS)

    def runs_page(
        self, query: Mapping[str, object], after: int | None, limit: int | None
    ) -> Call[tuple[list[RunDocument], int | None]]:
        """Return a page of the list of runs, of `limit` at most, and where the next one starts."""
        size = PAGE_MAX if limit is None else min(limit, PAGE_MAX)
        params = dict(query) | {"limit": size} | ({} if after is None else {"after": after})
        page = yield from self.document("GET", "/runs", params=params, needs=("runs", "next"))
        return page["runs"], page["next"]

    def show_sweep(self, sweep_id: int) -> Call[SweepDocument]:
        """Return a sweep in its present state."""
        return self.document("GET", f"/sweeps/{sweep_id}", needs=SWEEP_KEYS)

    def cancel_sweep(self, sweep_id: int) -> Call[SweepDocument]:
        """Cancel the runs of a sweep that have not ended."""
        return self.document("POST", f"/sweeps/{sweep_id}/cancel", needs=SWEEP_KEYS)

    def act(
        self, run_id: int, action: str, body: Mapping[str, object] | None = None
    ) -> Call[RunDocument]:
        """Change a run: cancel, publish or withdraw it."""
        content = {} if body is None else {"json": body}
        return self.document("POST", f"/runs/{run_id}/{action}", needs=RUN_KEYS, **content)

    def compare(
        self, run_ids: Sequence[int], query: Mapping[str, object]
    ) -> Call[ComparisonDocument]:
        """Return two to five runs side by side."""
        params = {"runs": ",".join(map(str, run_ids))} | dict(query)
        return self.document("GET", "/compare", params=params, needs=("runs", "scores"))

    def leaderboard(self, benchmark: str, query: Mapping[str, object]) -> Call[LeaderboardDocument]:
        """Return a page of a leaderboard."""
        path = f"/leaderboards/{benchmark}"
        return self.document("GET", path, params=dict(query), needs=("ranks", "next"))

    def benchmarks(self) -> Call[list[BenchmarkDocument]]:
        """Return all benchmarks."""
        document = yield from self.document("GET", "/benchmarks", needs=("benchmarks",))
        return cast("list[BenchmarkDocument]", document["benchmarks"])

    def competitions(self) -> Call[dict[str, Any]]:
        """Return the open competitions and the drafts of the account."""
        return self.document("GET", "/competitions", needs=("competitions", "drafts"))

    def competition(self, name: str) -> Call[dict[str, Any]]:
        """Return a competition."""
        return self.document("GET", _competition(name), needs=COMPETITION_KEYS)

    def competition_check(self, name: str) -> Call[dict[str, Any]]:
        """Return the check of a competition."""
        needs = ("ended", "asked", "waiting", "findings")
        return self.document("GET", f"{_competition(name)}/check", needs=needs)

    def competition_entries(self, name: str) -> Call[dict[str, Any]]:
        """Return what the team of the account has submitted."""
        path = f"{_competition(name)}/entries"
        return self.document("GET", path, needs=("entries", "left"))

    def write_competition(
        self, values: Mapping[str, Any], files: Mapping[str, str | Path | None], *, replaces: bool
    ) -> Call[dict[str, Any]]:
        """Make a draft, or replace the one of this name; with those files that are not None."""
        text = json.dumps(dict(values), default=_text_of_time)
        content: dict[str, Any] = {"content": text, "headers": {"Content-Type": _JSON}}
        paths = {name: Path(file) for name, file in files.items() if file is not None}
        if paths:
            parts = {name: (path.name, path.read_bytes()) for name, path in paths.items()}
            content = {"data": {"document": text}, "files": parts}
        method, path = "POST", "/competitions"
        if replaces:
            method, path = "PUT", _competition(str(values.get("name", "")))
        return self.document(method, path, needs=COMPETITION_KEYS, **content)

    def change_competition(
        self, name: str, step: str, body: Mapping[str, object] | None = None
    ) -> Call[dict[str, Any]]:
        """Open a competition, or move a round of it."""
        path, sent = f"{_competition(name)}/{step}", dict(body or {})
        return self.document("POST", path, needs=COMPETITION_KEYS, json=sent)

    def join_team(self, name: str, code: str) -> Call[dict[str, Any]]:
        """Join a team and agree on the rules."""
        path, body = f"{_competition(name)}/teams/join", {"code": code, "agree": True}
        return self.document("POST", path, needs=("name", "members"), json=body)

    def board(self, name: str, number: int, per: str) -> Call[dict[str, Any]]:
        """Return the board of a round."""
        path = f"{_competition(name)}/rounds/{number}/board"
        return self.document("GET", path, params={"per": per}, needs=BOARD_KEYS)

    def telemetry(self, run_id: int) -> Call[tuple[list[str], bytes, dict[str, str]]]:
        """Return the names of the columns, all rows so far as little-endian float64, and units."""
        response = yield from self.send("GET", f"/runs/{run_id}/telemetry.f64")
        names = [name for name in response.headers.get("X-Columns", "").split(",") if name]
        if not names or len(response.content) % (8 * len(names)):
            raise exchange.not_seamark(self.server)
        units = response.headers.get("X-Units", "").split(",")
        return names, response.content, dict(zip(names, units, strict=False))

    def benchmark(self, name: str) -> Call[dict[str, Any]]:
        """Return a benchmark with the schema of its settings."""
        return self.document("GET", f"/benchmarks/{name}", needs=("schema",))

    def account(self) -> Call[dict[str, Any]]:
        """Return the account of the token."""
        return self.document("GET", "/me", needs=("name", "quota"))

    def file(self, run_id: int, name: str) -> Call[dict[str, Any]]:
        """Return a JSON file of a run."""
        return self.document("GET", f"/runs/{run_id}/{name}")

    def text(self, run_id: int, name: str) -> Call[str]:
        """Return a text of a run."""
        response = yield from self.send("GET", f"/runs/{run_id}/{name}")
        return response.text

    def data(self, run_id: int, name: str) -> Call[bytes]:
        """Return a file of a run."""
        response = yield from self.send("GET", f"/runs/{run_id}/{name}")
        return response.content

    def download(self, run_id: int, kind: str, into: BinaryIO) -> Call[None]:
        """Write a run in one of `seamark.formats` into a file."""
        if kind not in FORMATS:
            raise ValueError(f"The formats are {', '.join(FORMATS)}, not {kind!r}.")
        path = f"{API}/runs/{run_id}/{FORMATS[kind].file}"
        response = yield from self._exchange(Request("GET", path, into=into))
        if response.headers.get("Content-Type", "").startswith("text/html"):  # a page of a proxy
            raise exchange.not_seamark(self.server)

    def _post_run(
        self,
        path: str,
        benchmark: str,
        options: SubmissionOptions,
        *,
        needs: Sequence[str],
        **more: object,
    ) -> Call[Any]:
        """Post a run or a sweep: of a built-in solution, or with files."""
        sent = {name: value for name, value in options.items() if value is not None}
        files = {name: Path(str(sent.pop(name))) for name in _FILES if name in sent}
        body = sent | {"benchmark": benchmark} | more
        content: dict[str, Any] = {"json": body}
        if files:
            parts = {name: (file.name, file.read_bytes()) for name, file in files.items()}
            content = {"data": {"run": json.dumps(body)}, "files": parts}
        # The server starts one run for a key, so that a request without an answer can be repeated.
        headers = {"Idempotency-Key": secrets.token_hex(16)} if self._signed_in else {}
        request = Request("POST", API + path, content | {"headers": headers}, self._signed_in)
        response = yield from self._exchange(request)
        return exchange.document(self.server, response, needs)


def _competition(name: str) -> str:
    return f"/competitions/{quote(name, safe='')}"


def _text_of_time(value: object) -> str:
    """Return a date or time as TOML files have them; raises TypeError for anything else."""
    if isinstance(value, date | time):
        return value.isoformat()
    raise TypeError(f"A document has no {type(value).__name__}.")
