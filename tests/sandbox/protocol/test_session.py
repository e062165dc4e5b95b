"""docs/conversation.txt: a whole conversation with the template of an executable, byte for byte.

`python -m tests.sandbox.protocol.test_session` writes it anew.
"""

import json
import os
import socket
import struct
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path

from seamark.sandbox.protocol.messages import OBSERVE, QUIT, RESET, frame
from seamark.server.programs import starter_files
from tests.worker.built import compiled_here

PAGE = Path(__file__).parents[3] / "docs" / "conversation.txt"
LAYOUT = [("t", 0), ("dt", 0), ("error", 3), ("target_visible", 0)]
CONFIG = {"kp": 0.5, "ki": 0.02}
WAITING = 2  # the number of the question that waits when the program starts
HEAD = """\
# A conversation with the template of `seamark init --language executable`; see protocol.md.
# Arguments: the descriptor, 2, and a file with the lines
#   t 0 / dt 0 / error 3 / target_visible 0 / {"kp": 0.5, "ki": 0.02}
# "<" is what the program sends, ">" what it gets, in hexadecimal digits.
"""


def questions() -> Iterator[bytes]:
    """Yield two levels of four steps and the last word."""
    number = WAITING
    for index in range(2):
        number += 1
        level = {"index": index, "count": 2, "duration_s": 0.2, "dt": 0.05, "t": index * 0.2}
        yield frame(RESET, number, json.dumps(level).encode())
        for tick in range(4):
            number += 1
            values = (index * 0.2 + tick * 0.05, 0.05, 0.1 + tick, -0.3, 2.0 / 3.0, tick != 2)
            yield frame(OBSERVE, number, struct.pack("<6d", *values))
    yield frame(QUIT, number + 1)


def conversation(folder: Path) -> str:
    """Return what is said, by the program compiled on this machine."""
    ((_, source),) = starter_files.start("executable").items()
    (folder / "client.c").write_bytes(source)
    compiled_here([folder / "client.c"], folder / "client")
    begin = folder / "begin"
    begin.write_text("".join(f"{name} {count}\n" for name, count in LAYOUT) + json.dumps(CONFIG))
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    ours.settimeout(20.0)
    with ours, theirs:
        command = [folder / "client", str(theirs.fileno()), str(WAITING), begin]
        program = subprocess.Popen(command, pass_fds=[theirs.fileno()])
        lines = [f"< {ours.recv(65536).hex()}"]
        for question in questions():
            ours.send(question)
            lines += [f"> {question.hex()}", f"< {ours.recv(65536).hex()}"]
        assert program.wait(20.0) == os.EX_OK
    return HEAD + "\n".join(lines) + "\n"


def test_the_conversation_of_the_page_is_that_of_the_template(tmp_path) -> None:
    assert conversation(tmp_path) == PAGE.read_text(encoding="utf-8")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as place:
        PAGE.write_text(conversation(Path(place)), encoding="utf-8")
