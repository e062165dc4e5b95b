"""Runs inside a box: compiles a stranger's source, or starts what came out of another box.

Arguments: `compile` with the compiler's command, or `start`, then `--`; then the number of the
protocol's descriptor, and processes and memory [MiB] to limit here, 0 where control groups do it.
A box holds nothing of ours but this file, runner.c and seamark.h; so the frames' numbers stand here
once more (docs/protocol.md). Nothing here is trusted by the other side.
"""

import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import NoReturn

from .connection import MOST_TEXT, Connection, connected

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
    connection.leave()


def run(
    connection: Connection, command: list[str], name: str, *, folder: Path | None = None
) -> None:
    """Run one step of the compilation; give up with its messages if it fails."""
    with MESSAGES.open("wb") as messages:
        code = subprocess.call(
            command, stdin=subprocess.DEVNULL, stdout=messages, stderr=messages, cwd=folder
        )
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


def start(connection: Connection) -> NoReturn:
    """Put the program where it can run and become it; layout and configuration go by a file."""
    header, program = connection.program()
    layout = header["layout"]
    lines = [f"{name} {count}" for name, count in layout["observation"]]
    BEGIN.write_text("\n".join([*lines, json.dumps(header["config"])]), encoding="ascii")
    LINKED.write_bytes(program)
    LINKED.chmod(0o700)
    arguments = [str(connection.fd), str(connection.sequence), str(BEGIN)]
    try:
        os.execve(LINKED, ["controller", *arguments], dict(os.environ))  # noqa: S606
    except OSError as error:
        connection.give_up(b"u", f"The compiled program cannot be started: {error.strerror}.")


def main() -> None:
    """Do what the first argument says."""
    split = sys.argv.index("--")
    action = sys.argv[1]
    connection = connected(sys.argv[split + 1 :], inherited=action == "start")
    connection.send(b"k")
    if action == "start":
        start(connection)
    compile_source(connection, sys.argv[2:split], ["/usr/bin/gcc", "-O2", "-std=c11"])


if __name__ == "__main__":
    main()
