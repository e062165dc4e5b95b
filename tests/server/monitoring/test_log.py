"""The log of the service."""

import json
import os
import pty
import subprocess
import sys
from pathlib import Path

import pytest

FULL = Path("/dev/full")  # every write fails as on a full disk
LOGS = """
import logging
import structlog
from seamark.server.monitoring import log

log.configure("info", "auto")
for number in range(2000):
    structlog.get_logger().error("event", number=number)
    logging.getLogger("library").error("event")
print("went on")
"""
HOSTILE = "x\n2026-01-01 [info] run_ended run=1\x1b[2J\x1b]0;title\x07\u2028\u202e\x9b\x00"
WRITES = """
import logging, sys, structlog
from seamark.server.monitoring import log

log.configure("info", sys.argv[1])
hostile = sys.argv[2].encode().decode("unicode_escape")
structlog.get_logger().debug("not_shown")
structlog.get_logger().info("event", why=hostile)
logging.getLogger("library").warning("says %s", hostile)
try:
    raise ValueError(hostile)
except ValueError:
    structlog.get_logger().exception("failed", run=7)
"""


def written(style: str) -> str:
    """Return what a process logs of hostile text."""
    text = HOSTILE.encode("unicode_escape").decode()
    command = [sys.executable, "-c", WRITES, style, text]
    return subprocess.run(command, capture_output=True, check=True, text=True).stderr


@pytest.mark.skipif(not FULL.exists(), reason="the system has no /dev/full")
def test_a_log_on_a_full_disk_stops_nobody_who_logs() -> None:
    with FULL.open("wb") as full:
        command = [sys.executable, "-c", LOGS]
        found = subprocess.run(command, stdout=subprocess.PIPE, stderr=full, check=False)

    assert found.stdout == b"went on\n"


def test_each_event_is_one_line_of_json_whatever_users_have_sent() -> None:
    text = written("auto")  # not on a terminal
    ours, library, failed = [json.loads(line) for line in text.splitlines()]

    assert text.isascii()
    assert all(c.isprintable() or c == "\n" for c in text)
    assert (ours["event"], ours["why"]) == ("event", HOSTILE)
    assert (library["event"], library["logger"]) == (f"says {HOSTILE}", "library")
    assert (failed["run"], failed["level"]) == (7, "error")
    assert failed["exception"].endswith(f"ValueError: {HOSTILE}")


def test_no_value_acts_on_a_terminal_or_makes_a_line_that_looks_like_an_event() -> None:
    text = written("text")
    events = [line for line in text.splitlines() if not line.startswith("    ")]

    assert all(c.isprintable() or c == "\n" for c in text)
    assert [line.split()[3] for line in events] == ["event", "says", "failed"]


def test_a_terminal_gets_text() -> None:
    terminal, theirs = pty.openpty()
    command = [sys.executable, "-c", WRITES, "auto", "x"]
    subprocess.run(command, stderr=theirs, check=True)
    os.close(theirs)

    assert not os.read(terminal, 4096).startswith(b"{")
    os.close(terminal)
