"""Runs inside a box: compiles a stranger's source, or starts what came out of another box.

Arguments: `compile` with the compiler's command, or `start`, then `--`; then the number of the
protocol's descriptor, and processes and memory [MiB] to limit here, 0 where control groups do it.
A box holds nothing of ours but this file, runner.c and seamark.h; so the frames' numbers stand here
once more (docs/protocol.md). Nothing here is trusted by the other side.
"""

import json
import os
import re
import resource
import struct
import subprocess
import sys
from pathlib import Path
from typing import NoReturn

VERSION = 1
HEADER = struct.Struct("<cB2xI")
SIZES = struct.Struct("<II")
ERROR = struct.Struct("<cH")
MOST_BYTES = 65536  # [B] one frame
MOST_SENTENCE, MOST_TEXT = 1500, 16000  # [B]
DESCRIPTORS = 4096  # above the limit of open files

NATIVE = Path("/box/native")
SOURCE, OBJECT, RUNNER = Path("/tmp/source"), "/tmp/program.o", "/tmp/runner.o"  # noqa: S108
LINKED, MESSAGES = Path("/tmp/program"), Path("/tmp/messages")  # noqa: S108
BEGIN = Path("/tmp/begin")  # noqa: S108  (read and removed by the runner)
OURS = (f"{SOURCE}/", f"{NATIVE}/", "/usr/bin/ld: ", "collect2: error: ld returned 1 exit status\n")
ASSEMBLY = re.compile(r"\S*/cc\w+\.s\b")  # what the compiler hands to the assembler
ERROR_LINE = re.compile(r"error:|Error:|undefined reference|multiple definition")
UNDEFINED = "undefined reference to `seamark_step'"
INTERFACE = (
    'A program has #include "seamark.h" and defines int seamark_step(const seamark_observation *, '
    "seamark_command *)."
)


class Connection:
    """The program's end of the protocol."""

    def __init__(self, descriptor: int) -> None:
        self.fd = descriptor
        self.sequence = 0

    def send(self, kind: bytes, body: bytes = b"") -> None:
        """Send one frame that answers the present question."""
        os.write(self.fd, HEADER.pack(kind, VERSION, self.sequence) + body)

    def receive(self) -> bytes:
        """Return the body of the next question; ends the process when the other side is gone."""
        data = os.read(self.fd, MOST_BYTES)
        if not data:
            os._exit(0)
        _, _, self.sequence = HEADER.unpack_from(data)
        return data[HEADER.size :]

    def program(self) -> tuple[dict[str, object], bytes]:
        """Receive header and program."""
        header_size, source_size = SIZES.unpack(self.receive())
        data = bytearray()
        while len(data) < header_size + source_size:
            data += self.receive()
        return json.loads(data[:header_size]), bytes(data[header_size:])

    def give_up(self, kind: bytes, sentence: str, text: str = "") -> NoReturn:
        """Send the last frame and end."""
        words = sentence.encode("utf-8", "replace")[:MOST_SENTENCE]
        trace = text.encode("utf-8", "replace")[:MOST_TEXT]
        self.send(b"x", ERROR.pack(kind, len(words)) + words + trace)
        os._exit(1)


def compile_source(connection: Connection, command: list[str], runner_command: list[str]) -> None:
    """Compile and link; the program leaves over the standard output, nothing else does."""
    header, source = connection.program()
    name = str(header["filename"])
    SOURCE.mkdir()
    (SOURCE / name).write_bytes(source)
    run(connection, [*command, "-c", f"{SOURCE}/{name}", "-o", OBJECT], name)
    run(connection, [*runner_command, "-c", f"{NATIVE}/runner.c", "-o", RUNNER], name)
    run(connection, [command[0], OBJECT, RUNNER, "-o", str(LINKED), "-lm"], name)
    sys.stdout.buffer.write(LINKED.read_bytes())
    sys.stdout.buffer.flush()
    connection.send(b"k")
    connection.receive()
    connection.send(b"q")


def run(connection: Connection, command: list[str], name: str) -> None:
    """Run one step of the compilation; give up with its messages if it fails."""
    with MESSAGES.open("wb") as messages:
        code = subprocess.call(command, stdin=subprocess.DEVNULL, stdout=messages, stderr=messages)
    if not code:
        return
    with MESSAGES.open("rb") as messages:
        text = messages.read(MOST_TEXT).decode("utf-8", "replace")
    for ours in OURS:
        text = text.replace(ours, "")
    text = text.replace(OBJECT, name).replace(RUNNER, "runner.c")
    text = ASSEMBLY.sub(f"{name} (assembly)", text)
    if "Killed signal" in text:
        connection.give_up(b"m", "The compiler needed more memory than it may use.", text)
    connection.give_up(b"s", first_error(text, name), text)


def first_error(text: str, name: str) -> str:
    """Return the first error as one sentence."""
    if UNDEFINED in text:
        return f"{name} does not define seamark_step. {INTERFACE}"
    lines = text.splitlines()
    errors = [line for line in lines if ERROR_LINE.search(line)]
    return (errors or lines or [f"{name} cannot be compiled."])[0]


def start(connection: Connection, descriptor: int) -> NoReturn:
    """Put the program where it can run and become it; layout and configuration go by a file."""
    header, program = connection.program()
    layout = header["layout"]
    lines = [f"{name} {count}" for name, count in layout["observation"]]  # type: ignore[index]
    BEGIN.write_text("\n".join([*lines, json.dumps(header["config"])]), encoding="ascii")
    LINKED.write_bytes(program)
    LINKED.chmod(0o700)
    arguments = [str(descriptor), str(connection.sequence), str(BEGIN)]
    try:
        os.execve(LINKED, ["controller", *arguments], dict(os.environ))  # noqa: S606
    except OSError as error:
        connection.give_up(b"u", f"The compiled program cannot be started: {error.strerror}.")


def limit(which: int, value: int) -> None:
    """Lower a limit for good; 0 leaves it."""
    if value:
        resource.setrlimit(which, (value, value))


def main() -> None:
    """Close what is not needed, set the limits, do what the first argument says."""
    split = sys.argv.index("--")
    descriptor, processes, memory_mib = (int(word) for word in sys.argv[split + 1 :])
    os.closerange(3, descriptor)
    os.closerange(descriptor + 1, DESCRIPTORS)
    limit(resource.RLIMIT_NPROC, processes)
    limit(resource.RLIMIT_AS, memory_mib << 20)
    os.set_inheritable(descriptor, sys.argv[1] == "start")
    connection = Connection(descriptor)
    connection.send(b"k")
    if sys.argv[1] == "start":
        start(connection, descriptor)
    compile_source(connection, sys.argv[2:split], ["/usr/bin/gcc", "-O2", "-std=c11"])


if __name__ == "__main__":
    main()
