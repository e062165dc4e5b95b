"""The Python client: submits runs to a server and follows them."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Self, cast

import httpx

TIMEOUT_S = 30.0
GET_ATTEMPTS = 5  # other requests are never repeated
MAX_WAIT_S = 5.0
FINAL = frozenset({"succeeded", "failed", "cancelled"})


class ServerRefused(Exception):
    """The server refused a request; `problem` is its RFC 9457 document."""

    def __init__(self, problem: Mapping[str, Any]) -> None:
        self.problem = dict(problem)
        self.status = int(problem.get("status", 0))
        super().__init__(_message(problem))


class ServerUnavailable(Exception):
    """The server does not answer, or is not a Seamark server."""


class Client:
    """A connection to one server; a context manager.

    Examples
    --------
    >>> with Client("http://127.0.0.1:8000", token="smk_...") as server:  # doctest: +SKIP
    ...     run = server.submit("currents-v1", program=Path("controller.py"))
    ...     print(server.wait(run["id"])["result"])
    """

    def __init__(
        self, server: str, token: str | None = None, *, transport: httpx.BaseTransport | None = None
    ) -> None:
        headers = {"Accept": "application/json", "User-Agent": "seamark"}
        if token:
            headers["Authorization"] = f"Bearer {token}"
        self.server = server.rstrip("/")
        self._http = httpx.Client(
            base_url=self.server, headers=headers, timeout=TIMEOUT_S, transport=transport
        )

    def __enter__(self) -> Self:
        """Return the client."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Close the connections."""
        self._http.close()

    def submit(
        self,
        benchmark: str,
        *,
        controller: str | None = None,
        program: Path | None = None,
        config: Mapping[str, object] | None = None,
        **more: object,
    ) -> dict[str, Any]:
        """Submit a run and return it. `more` may hold kind, seed, trials and title.

        Raises
        ------
        ServerRefused, ServerUnavailable
        """
        run = more | {"benchmark": benchmark, "config": config}
        return self._post_run("/api/v1/runs", run, controller, program)

    def sweep(
        self,
        benchmark: str,
        axes: Mapping[str, str],
        *,
        controller: str | None = None,
        program: Path | None = None,
        **more: object,
    ) -> dict[str, Any]:
        """Start a sweep and return it; `axes` has what is swept with its values as a text.

        `more` may hold config and what `submit` takes.

        Raises
        ------
        ServerRefused, ServerUnavailable
        """
        swept = [{"name": name, "values": values} for name, values in axes.items()]
        run = more | {"benchmark": benchmark, "sweep": swept}
        return self._post_run("/api/v1/sweeps", run, controller, program)

    def run(self, run_id: int) -> dict[str, Any]:
        """Return a run in its present state."""
        return self._json("GET", f"/api/v1/runs/{run_id}")

    def compare(self, run_ids: Sequence[int], **query: object) -> dict[str, Any]:
        """Return two to five runs side by side. `query` may hold columns, trial and level."""
        params = {"runs": ",".join(map(str, run_ids))} | query
        return self._json("GET", "/api/v1/compare", params=params)

    def leaderboard(self, benchmark: str, **query: object) -> dict[str, Any]:
        """Return a page of a leaderboard. `query` may hold its filters, sort, after and limit."""
        return self._json("GET", f"/api/v1/leaderboards/{benchmark}", params=dict(query))

    def follow(self, run_id: int) -> Iterator[dict[str, Any]]:
        """Yield the run each time it changes, until it has ended."""
        version, wait_s = "", 0.2
        while True:
            response = self._send(
                "GET", f"/api/v1/runs/{run_id}", headers={"If-None-Match": version}
            )
            if response.status_code != 304:
                run: dict[str, Any] = response.json()
                version = response.headers.get("ETag", "")
                yield run
                if run["state"] in FINAL:
                    return
            time.sleep(wait_s)
            hint = response.headers.get("Retry-After", "1")
            wait_s = min(float(hint) if hint.isdecimal() else 1.0, MAX_WAIT_S)

    def wait(
        self, run_id: int, on_change: Callable[[dict[str, Any]], None] | None = None
    ) -> dict[str, Any]:
        """Return the run once it has ended."""
        last: dict[str, Any] = {}
        for last in self.follow(run_id):
            if on_change is not None:
                on_change(last)
        return last

    def _post_run(
        self, path: str, sent: Mapping[str, object], controller: str | None, program: Path | None
    ) -> dict[str, Any]:
        """Post a run or a sweep: of a built-in solution, or with a program."""
        run = {name: value for name, value in sent.items() if value is not None}
        run["config"] = dict(cast("Mapping[str, object]", run.get("config", {})))
        if program is None:
            return self._json("POST", path, json=run | {"controller": controller})
        files = {"program": (program.name, program.read_bytes())}
        return self._json("POST", path, data={"run": json.dumps(run)}, files=files)

    def _json(self, method: str, path: str, **options: Any) -> dict[str, Any]:
        response = self._send(method, path, **options)
        try:
            value = response.json()
        except ValueError:
            value = None
        if not isinstance(value, dict):
            raise ServerUnavailable(f"{self.server} is not a Seamark server. Check the address.")
        return value

    def _send(self, method: str, path: str, **options: Any) -> httpx.Response:
        """Send a request; repeat it after a connection error only if it is a GET."""
        attempts = GET_ATTEMPTS if method == "GET" else 1
        for attempt in range(1, attempts + 1):
            try:
                response = self._http.request(method, path, **options)
            except (httpx.InvalidURL, httpx.UnsupportedProtocol) as error:
                raise ServerUnavailable(
                    f"{self.server} is not the address of a server: {error}."
                ) from None
            except httpx.TransportError as error:
                if attempt == attempts:
                    raise ServerUnavailable(f"{self.server} does not answer: {error}.") from None
                time.sleep(min(0.3 * 2**attempt, MAX_WAIT_S))
                continue
            if response.status_code >= 400:
                raise _refusal(response)
            return response
        raise ServerUnavailable(f"{self.server} does not answer.")


def _refusal(response: httpx.Response) -> Exception:
    try:
        problem = response.json()
    except ValueError:
        problem = None
    if not isinstance(problem, dict) or "title" not in problem:
        return ServerUnavailable(
            f"{response.request.url} answered {response.status_code} {response.reason_phrase}."
        )
    return ServerRefused(problem)


def _message(problem: Mapping[str, Any]) -> str:
    detail = str(problem.get("detail") or problem.get("title") or "The server refused.")
    if problem.get("type") == "/problems/invalid-configuration":
        return detail  # it has the messages of all fields
    fields = [f"{e['field']}: {e['detail']}" for e in problem.get("errors", [])]
    return " ".join([detail, *(text for text in fields if detail not in text)])
