import os
import threading
from collections.abc import Iterator

import pytest

from seamark.sandbox.isolation.bwrap_status import BwrapStatus

REPORT = b'{ "child-pid": 4711, "net-namespace": 4026532 }\n'


@pytest.fixture
def pipe() -> Iterator[tuple[int, int]]:
    reading, writing = os.pipe()
    os.set_blocking(reading, False)
    yield reading, writing
    os.close(writing)


@pytest.mark.parametrize("cut", range(1, len(REPORT)))
def test_an_incomplete_line_is_waited_for(pipe: tuple[int, int], cut: int) -> None:
    reading, writing = pipe
    information = BwrapStatus(reading)

    os.write(writing, REPORT[:cut])
    early = information.init_pid()
    rest = threading.Thread(target=os.write, args=(writing, REPORT[cut:]))
    rest.start()
    late = information.init_pid(10.0)
    rest.join()
    information.close()

    assert (early, late) == (None, 4711)


def test_a_failed_start_reports_no_pid() -> None:
    reading, writing = os.pipe()
    os.write(writing, REPORT[:20])
    os.close(writing)
    information = BwrapStatus(reading)

    assert information.init_pid(10.0) is None
    information.close()
    information.close()


def test_the_exit_code_is_known_once_it_is_reported(pipe: tuple[int, int]) -> None:
    reading, writing = pipe
    information = BwrapStatus(reading)

    os.write(writing, REPORT)
    early = information.exit_code()
    os.write(writing, b'{ "exit-code": 137 }\n')
    pid, late = information.init_pid(), information.exit_code()
    information.close()

    assert (early, pid, late) == (None, 4711, 137)
