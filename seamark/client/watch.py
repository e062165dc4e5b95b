"""Following a run or a sweep to its end."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import Any

from seamark.client import exchange
from seamark.client.calls import Calls
from seamark.client.errors import StillRunning
from seamark.client.exchange import Call, Pause

FINAL = frozenset({"succeeded", "failed", "cancelled"})
FIRST_WAIT_S, DEFAULT_WAIT_S, WAIT_MAX_S = 0.2, 1.0, 5.0  # between two questions

Document = Mapping[str, Any]


class Watch:
    """Asks for a run or a sweep until it has ended.

    Parameters
    ----------
    calls, path
        What is asked, and where.
    ended
        Tells whether a document is the last one.
    timeout_s
        After how long StillRunning is raised; None: never.
    """

    def __init__(
        self, calls: Calls, path: str, ended: Callable[[Any], bool], *, timeout_s: float | None
    ) -> None:
        self._calls, self._path, self._ended = calls, path, ended
        self._timeout_s = timeout_s
        self._deadline = None if timeout_s is None else time.monotonic() + timeout_s
        self._version = ""
        self._wait_s = 0.0
        self._done = False

    def next_change(self) -> Call[Any]:
        """Return the document once it has changed; None after the last one."""
        while not self._done:
            if self._wait_s:
                self._check_deadline()
                yield Pause(self._wait_s)
            known = {"If-None-Match": self._version} if self._version else {}
            response = yield from self._calls.send("GET", self._path, headers=known)
            first = self._wait_s == 0.0
            hint = exchange.retry_after_s(response)
            asked_s = DEFAULT_WAIT_S if hint is None else max(hint, FIRST_WAIT_S)
            self._wait_s = FIRST_WAIT_S if first else min(asked_s, WAIT_MAX_S)
            if response.status_code != 304:
                change = exchange.document(self._calls.server, response)
                self._version = response.headers.get("ETag", "")
                self._done = self._ended(change)
                return change
        return None

    def _check_deadline(self) -> None:
        if self._deadline is not None and time.monotonic() + self._wait_s > self._deadline:
            what = self._path.strip("/").replace("s/", " ")
            raise StillRunning(
                f"The {what} has not ended within {self._timeout_s:g} s. It goes on."
            )


def run_ended(run: Document) -> bool:
    """Tell whether a run has ended."""
    return run["state"] in FINAL


def sweep_ended(sweep: Document) -> bool:
    """Tell whether all runs of a sweep have ended."""
    return not sweep["live"]


def watch_run(calls: Calls, run_id: int, *, timeout_s: float | None) -> Watch:
    """Return what follows a run."""
    return Watch(calls, f"/runs/{run_id}", run_ended, timeout_s=timeout_s)


def watch_sweep(calls: Calls, sweep_id: int, *, timeout_s: float | None) -> Watch:
    """Return what follows a sweep."""
    return Watch(calls, f"/sweeps/{sweep_id}", sweep_ended, timeout_s=timeout_s)
