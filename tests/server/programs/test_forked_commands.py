"""Commands that tests fork instead of starting them: what their callers see is the same."""

import io
import resource
import signal
import subprocess
import time
from contextlib import closing

from seamark.programs.preparation import PreparedProgram
from seamark.server.programs import reader, reader_process
from tests.services import forked_commands, uploads
from tests.services.forked_commands import ForkedCommand


def _fork() -> ForkedCommand:
    pipe = subprocess.PIPE
    return ForkedCommand(reader._COMMAND, stdin=pipe, stdout=pipe, stderr=pipe, env={})


def _read(source: bytes) -> PreparedProgram:
    with closing(uploads.ReaderWithoutSpare()) as made:
        stream = io.BytesIO(source)
        return made.read_upload(stream, "a.py", owner="ann", limit=1000, role="controller")


def test_a_forked_command_answers_as_one_that_is_started() -> None:
    source = b"class Controller: pass\n"

    forked = _read(source)
    with forked_commands.started_anew():
        started = _read(source)

    assert forked == started


def test_a_forked_command_is_a_child_that_can_be_killed() -> None:
    with _fork() as process:
        process.kill()

        assert process.wait() == -signal.SIGKILL


def test_a_forked_command_limits_itself() -> None:
    memory = reader_process.MEMORY_MIB << 20
    deadline = time.monotonic() + 30

    with _fork() as process:  # it waits for a request
        while (found := resource.prlimit(process.pid, resource.RLIMIT_AS)) != (memory, memory):
            assert time.monotonic() < deadline, found
            time.sleep(0.01)  # a process does not announce its limits
        process.kill()


def test_a_forked_command_that_fails_says_why() -> None:
    with _fork() as process:
        _, errors = process.communicate(b"no json")

    assert process.returncode == 1
    assert b"JSONDecodeError" in errors
