"""How a forked process ends, and when one that died is started again."""

import subprocess
import sys

import pytest

from seamark.worker.ipc.process_control import RestartBackoff, exit_reason


def test_each_death_in_a_row_doubles_the_wait_up_to_a_maximum() -> None:
    backoff = RestartBackoff(first_s=0.5, longest_s=3.0)

    assert [backoff.next_wait_s() for _ in range(5)] == [0.5, 1.0, 2.0, 3.0, 3.0]


@pytest.mark.parametrize(("lived_s", "wait_s"), [(59.0, 1.0), (60.0, 0.5)])
def test_only_a_steady_life_makes_up_for_a_death(lived_s: float, wait_s: float) -> None:
    backoff = RestartBackoff(first_s=0.5, steady_s=60.0)
    backoff.next_wait_s()

    backoff.note_life(lived_s)

    assert backoff.next_wait_s() == wait_s


def test_the_end_of_a_process_has_a_name() -> None:
    assert (exit_reason(3), exit_reason(-9)) == ("exit code 3", "SIGKILL")


FORKS = """
import os
from seamark.worker.ipc.process_control import run_forked

reader, writer = os.pipe()
child = os.fork()
if not child:
    run_forked(lambda: 1 / 0, lambda text: os.write(writer, text.encode()))
code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
print(code, os.read(reader, 10000).decode().splitlines()[-1])
"""


def test_a_fork_reports_its_crash_and_ends_even_if_its_log_is_on_a_full_disk() -> None:
    with open("/dev/full", "wb") as full:
        command = [sys.executable, "-c", FORKS]
        found = subprocess.run(command, stdout=subprocess.PIPE, stderr=full, check=False)

    assert found.stdout == b"70 ZeroDivisionError: division by zero\n"
