"""Runs inside a box: compiles a stranger's source.

Arguments: `compile` with the compiler's command, then `--`; then the number of the protocol's
descriptor, and processes and memory [MiB] to limit here, 0 where control groups do it. A box holds
nothing of ours but this folder, runner.c and seamark.h. Nothing here is trusted by the other side.
"""

import io
import re
import subprocess
import sys
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path

from .connection import MOST_TEXT, Connection, connected
from .embedded import Unfit, adapter, looks_generated

NATIVE = Path("/box/native")
SOURCE, OBJECTS = Path("/tmp/source"), Path("/tmp/objects")  # noqa: S108
RUNNER = "/tmp/runner.o"  # noqa: S108
ARCHIVE, MAIN, ADAPTER = b"PK\x03\x04", "ert_main", "seamark_connection.c"
LINKED, MESSAGES = Path("/tmp/program"), Path("/tmp/messages")  # noqa: S108
OURS = (f"{SOURCE}/", f"{NATIVE}/", "/usr/bin/ld: ", "collect2: error: ld returned 1 exit status\n")
ASSEMBLY = re.compile(r"\S*/cc\w+\.s\b")  # what the compiler hands to the assembler
ERROR_LINE = re.compile(r"error:|Error:|undefined reference|multiple definition")
EMPTY: Mapping[str, str] = {}


def compile_source(connection: Connection, command: list[str], runner_command: list[str]) -> None:
    """Compile and link; the program leaves over the standard output, nothing else does."""
    header, source = connection.program()
    name = str(header["filename"])
    files = placed(connection, name, source)
    try:
        files = connected_by_names(files)
    except Unfit as reason:
        connection.give_up(b"s", str(reason))
    objects = {f"{OBJECTS}/{index}.o": file for index, file in enumerate(files)}
    for target, file in objects.items():
        run(connection, [*command, f"-I{SOURCE}", "-c", f"{SOURCE}/{file}", "-o", target], name)
    run(connection, [*runner_command, "-c", f"{NATIVE}/runner.c", "-o", RUNNER], name)
    linking = [command[0], *objects, RUNNER, "-o", str(LINKED), "-lm"]
    run(connection, linking, name, named=objects)
    sys.stdout.buffer.write(LINKED.read_bytes())
    sys.stdout.buffer.flush()
    connection.send(b"k")
    connection.receive()
    connection.leave()


def placed(connection: Connection, name: str, source: bytes) -> list[str]:
    """Put the text, or the files of an archive, where the compiler finds them; return the sources.

    What makes a program of its own of a model (ert_main.c) is left out: the runner is that here.
    """
    SOURCE.mkdir()
    OBJECTS.mkdir()
    if not source.startswith(ARCHIVE):
        (SOURCE / name).write_bytes(source)
        return [name]
    try:
        with zipfile.ZipFile(io.BytesIO(source)) as archive:
            archive.extractall(SOURCE)
            names = sorted(archive.namelist())
    except (zipfile.BadZipFile, zlib.error, OSError, RuntimeError, NotImplementedError) as error:
        connection.give_up(b"s", f"{name} cannot be unpacked: {error}.")
    suffixes = (".cpp", ".cc") if "-xc++" in sys.argv else (".c",)
    sources = [file for file in names if file.endswith(suffixes) and MAIN not in file]
    return sources or connection.give_up(b"s", f"{name} has no file that ends in {suffixes[0]}.")


def connected_by_names(files: list[str]) -> list[str]:
    """Return what to compile: with a connecting file if this is the code of a model."""
    headers = sorted(str(path.relative_to(SOURCE)) for path in SOURCE.rglob("*.h"))
    texts = [(SOURCE / file).read_text("utf-8", "replace") for file in (*headers, *files)]
    text = "\n".join(texts)
    if not looks_generated(text):
        return files
    # A model of one file has its types there and nowhere else: it is taken in whole.
    alone = not headers
    (SOURCE / ADAPTER).write_text(adapter(text, files if alone else headers), encoding="utf-8")
    return [ADAPTER] if alone else [*files, ADAPTER]


def run(
    connection: Connection,
    command: list[str],
    name: str,
    *,
    folder: Path | None = None,
    named: Mapping[str, str] = EMPTY,
) -> None:
    """Run one step of the compilation; give up with its messages if it fails.

    `named` says of which file each object is.
    """
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
    for path, file in {**named, RUNNER: "runner.c"}.items():
        text = text.replace(path, file)
    text = ASSEMBLY.sub(f"{name} (assembly)", text)
    if "Killed signal" in text:
        connection.give_up(b"m", "The compiler needed more memory than it may use.", text)
    connection.give_up(b"s", first_error(text, name), text)


def first_error(text: str, name: str) -> str:
    """Return the first error as one sentence."""
    lines = text.splitlines()
    errors = [line for line in lines if ERROR_LINE.search(line)]
    return (errors or lines or [f"{name} cannot be compiled."])[0]


def main() -> None:
    """Compile what comes with the command that stands before `--`."""
    split = sys.argv.index("--")
    connection = connected(sys.argv[split + 1 :])
    connection.send(b"k")
    compile_source(connection, sys.argv[2:split], ["/usr/bin/gcc", "-O2", "-std=c11"])
