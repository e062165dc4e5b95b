"""A reader who takes nothing, or next to nothing, is given up."""

import os
import signal
import subprocess
import sys
import time

import pytest

PROGRAM = """
import sys
from seamark.server.runs.downloads.slow_readers import DeadlineOutput

output = DeadlineOutput(sys.stdout.buffer, patience_s=0.3, pace_bytes_s=1e6)
for _ in range(30):
    output.write(b"x" * 100_000)
"""
BYTES = 30 * 100_000


def writer() -> "subprocess.Popen[bytes]":
    return subprocess.Popen([sys.executable, "-c", PROGRAM], stdout=subprocess.PIPE)


@pytest.mark.slow
def test_a_reader_who_takes_nothing_is_given_up() -> None:
    with writer() as process:
        assert process.wait(60) == -signal.SIGALRM


@pytest.mark.slow
def test_a_reader_who_takes_a_little_now_and_then_is_given_up() -> None:
    with writer() as process:
        assert process.stdout is not None
        taken = 0
        while piece := os.read(process.stdout.fileno(), 1000):
            taken += len(piece)
            time.sleep(0.02)  # 50 kB/s at most

        assert process.wait(60) == -signal.SIGALRM
        assert taken < BYTES


def test_a_reader_who_reads_gets_everything() -> None:
    with writer() as process:
        assert process.stdout is not None
        assert len(process.stdout.read()) == BYTES
        assert process.wait(60) == 0
