"""The probes in a process of their own, so that the caller does something else meanwhile."""

import os
import pickle
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import NoReturn

from seamark.sandbox.probing.probes import IsolationReport, probe


@contextmanager
def probing() -> Iterator[Callable[[], IsolationReport]]:
    """Probe in a fork of this process; provide the function that waits for the report.

    Leaving the context waits for the fork, a second at most.
    """
    reader, writer = os.pipe()
    pid = os.fork()
    if pid == 0:
        os.close(reader)
        _report_to(writer)
    os.close(writer)
    try:
        with os.fdopen(reader, "rb") as pipe:
            yield lambda: _report_from(pipe.read())
    finally:
        os.waitpid(pid, 0)


def _report_to(writer: int) -> NoReturn:
    """Be the fork: never returns, and prints nothing if it fails or is interrupted."""
    try:
        with os.fdopen(writer, "wb") as pipe:
            pickle.dump(probe(), pipe)
    finally:
        os._exit(0)


def _report_from(pickled: bytes) -> IsolationReport:
    """Return the report of the fork; if it could not make one, the caller finds out why."""
    if not pickled:
        return probe()
    report: IsolationReport = pickle.loads(pickled)  # noqa: S301 - from a fork of this very process
    return report
