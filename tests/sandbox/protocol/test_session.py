"""docs/conversation.txt: a whole session with the starter of an executable, byte for byte.

`python -m tests.sandbox.protocol.test_session` rewrites it.
"""

import json
import os
import socket
import struct
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path

from seamark.sandbox.languages.executable import EXECUTABLE
from seamark.sandbox.protocol.messages import OBSERVE, QUIT, RESET, message
from tests.sandbox.host_compiler import compiled_on_host

PAGE = Path(__file__).parents[3] / "docs" / "conversation.txt"
LAYOUT = [("t", 0), ("dt", 0), ("error", 3), ("target_visible", 0)]
CONFIG = {"kp": 0.5, "ki": 0.02}
PENDING = 2  # the number of the pending request when the program starts
HEAD = """\
# A session with the program of `seamark init --language executable`; see protocol.md.
# Arguments: the descriptor, 2, and a file with the lines
#   t 0 / dt 0 / error 3 / target_visible 0 / {"kp": 0.5, "ki": 0.02}
# "<" is sent by the program, ">" by the simulator, in hexadecimal digits.
"""


def requests() -> Iterator[bytes]:
    """Yield two levels of four steps, then quit."""
    number = PENDING
    for index in range(2):
        number += 1
        level = {"index": index, "count": 2, "duration_s": 0.2, "dt": 0.05, "t": index * 0.2}
        yield message(RESET, number, json.dumps(level).encode())
        for step in range(4):
            number += 1
            values = (index * 0.2 + step * 0.05, 0.05, 0.1 + step, -0.3, 2.0 / 3.0, step != 2)
            yield message(OBSERVE, number, struct.pack("<6d", *values))
    yield message(QUIT, number + 1)


def session(folder: Path) -> str:
    """Return all messages of a session with the program, compiled on this machine."""
    (folder / "client.c").write_text(EXECUTABLE.starters[0].text())
    compiled_on_host([folder / "client.c"], folder / "client")
    begin = folder / "begin"
    begin.write_text("".join(f"{name} {count}\n" for name, count in LAYOUT) + json.dumps(CONFIG))
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    ours.settimeout(20.0)
    with ours, theirs:
        command = [folder / "client", str(theirs.fileno()), str(PENDING), begin]
        program = subprocess.Popen(command, pass_fds=[theirs.fileno()])
        lines = [f"< {ours.recv(65536).hex()}"]
        for request in requests():
            ours.send(request)
            lines += [f"> {request.hex()}", f"< {ours.recv(65536).hex()}"]
        assert program.wait(20.0) == os.EX_OK
    return HEAD + "\n".join(lines) + "\n"


def test_the_session_of_the_page_is_that_of_the_starter(tmp_path) -> None:
    assert session(tmp_path) == PAGE.read_text(encoding="utf-8")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        PAGE.write_text(session(Path(folder)), encoding="utf-8")
