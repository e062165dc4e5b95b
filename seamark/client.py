"""The Python client: order runs on a server and follow them."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import httpx

TIMEOUT_S = 30.0
TRIES = 5  # of a question that changes nothing
LONGEST_WAIT_S = 5.0
FINAL = frozenset({"succeeded", "failed", "cancelled"})


class ServerRefused(Exception):
    """The server said no. The text is its sentence; `problem` is its document."""

    def __init__(self, problem: Mapping[str, Any]) -> None:
        self.problem = dict(problem)
        self.status = int(problem.get("status", 0))
        super().__init__(_sentence(problem))


class ServerAway(Exception):
    """The server does not answer, or not as Seamark does."""


class Client:
    """Speaks to one server; a context manager.

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
        """Order a run and return it. `more` are further keys of the order: kind, seed, trials.

        Raises
        ------
        ServerRefused, ServerAway
        """
        order: dict[str, object] = {"benchmark": benchmark, "config": dict(config or {})}
        order |= {name: value for name, value in more.items() if value is not None}
        if program is None:
            return self._json("POST", "/api/v1/runs", json=order | {"controller": controller})
        files = {"program": (program.name, program.read_bytes())}
        return self._json("POST", "/api/v1/runs", data={"run": json.dumps(order)}, files=files)

    def run(self, run_id: int) -> dict[str, Any]:
        """Return a run as it is now."""
        return self._json("GET", f"/api/v1/runs/{run_id}")

    def follow(self, run_id: int) -> Iterator[dict[str, Any]]:
        """Yield the run whenever it has changed, until it has ended."""
        version, wait_s = "", 0.2
        while True:
            found = self._ask("GET", f"/api/v1/runs/{run_id}", headers={"If-None-Match": version})
            if found.status_code != 304:
                run: dict[str, Any] = found.json()
                version = found.headers.get("ETag", "")
                yield run
                if run["state"] in FINAL:
                    return
            time.sleep(wait_s)
            hint = found.headers.get("Retry-After", "1")
            wait_s = min(float(hint) if hint.isdecimal() else 1.0, LONGEST_WAIT_S)

    def wait(
        self, run_id: int, on_change: Callable[[dict[str, Any]], None] | None = None
    ) -> dict[str, Any]:
        """Return the run when it has ended."""
        last: dict[str, Any] = {}
        for last in self.follow(run_id):
            if on_change is not None:
                on_change(last)
        return last

    def _json(self, method: str, path: str, **options: Any) -> dict[str, Any]:
        found = self._ask(method, path, **options)
        try:
            value = found.json()
        except ValueError:
            value = None
        if not isinstance(value, dict):
            raise ServerAway(f"{self.server} answers, but not as Seamark does. Check the address.")
        return value

    def _ask(self, method: str, path: str, **options: Any) -> httpx.Response:
        """Send a request; questions are asked again when the line breaks, orders never are."""
        tries = TRIES if method == "GET" else 1
        for attempt in range(1, tries + 1):
            try:
                found = self._http.request(method, path, **options)
            except (httpx.InvalidURL, httpx.UnsupportedProtocol) as error:
                raise ServerAway(f"{self.server} is no address of a server: {error}.") from None
            except httpx.TransportError as error:
                if attempt == tries:
                    raise ServerAway(f"{self.server} does not answer: {error}.") from None
                time.sleep(min(0.3 * 2**attempt, LONGEST_WAIT_S))
                continue
            if found.status_code >= 400:
                raise _refusal(found)
            return found
        raise ServerAway(f"{self.server} does not answer.")


def _refusal(found: httpx.Response) -> Exception:
    try:
        problem = found.json()
    except ValueError:
        problem = None
    if not isinstance(problem, dict) or "title" not in problem:
        return ServerAway(
            f"{found.request.url} answered {found.status_code} {found.reason_phrase}."
        )
    return ServerRefused(problem)


def _sentence(problem: Mapping[str, Any]) -> str:
    detail = str(problem.get("detail") or problem.get("title") or "The server refused.")
    if problem.get("type") == "/problems/invalid-configuration":
        return detail  # the sentences of the fields already
    fields = [f"{e['field']}: {e['detail']}" for e in problem.get("errors", [])]
    return " ".join([detail, *(text for text in fields if detail not in text)])
