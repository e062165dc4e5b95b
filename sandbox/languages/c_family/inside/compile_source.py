"""Runs inside a box: compiles the user's source.

Arguments: the compiler's command, then `--`; then the number of the socket's descriptor, and the
limits of processes and memory [MiB] to set here, 0 if control groups enforce them.
"""

import io
import re
import subprocess
import sys
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path

from ...inside.connection import MAX_TEXT_BYTES, Connection, connected
from .embedded_coder import Unfit, adapter, looks_generated

NATIVE = Path("/box/native")
SOURCE, OBJECTS = Path("/tmp/source"), Path("/tmp/objects")  # noqa: S108
COMPILE_OURS = ("/usr/bin/gcc", "-O2", "-std=c11")
RUNNER = {"runner.o": "runner.c", "crash.o": "crash.c"}
BACKTRACE = Path("/usr/lib/gcc"), "*/*/libbacktrace.a"
ZIP_MAGIC, CODER_MAIN, ADAPTER = b"PK\x03\x04", "ert_main", "seamark_connection.c"
PROGRAM, MESSAGES = Path("/tmp/program"), Path("/tmp/messages")  # noqa: S108
AS_NEEDED = "-Wl,--as-needed"  # a program loads only the libraries that it uses
OURS = (f"{SOURCE}/", f"{NATIVE}/", "/usr/bin/ld: ", "collect2: error: ld returned 1 exit status\n")
ASSEMBLY = re.compile(r"\S*/cc\w+\.s\b")  # the compiler's output for the assembler
ERROR_LINE = re.compile(r"error:|Error:|undefined reference|multiple definition")
EMPTY: Mapping[str, str] = {}


def compile_source(connection: Connection, command: list[str]) -> None:
    """Compile and link; the program, and nothing else, goes to standard output."""
    header, source = connection.program()
    name = str(header["filename"])
    files = write_sources(connection, name, source)
    try:
        files = with_adapter(files)
    except Unfit as reason:
        connection.give_up(b"s", str(reason))
    objects = {f"{OBJECTS}/{index}.o": file for index, file in enumerate(files)}
    for target, file in objects.items():
        run(connection, [*command, f"-I{SOURCE}", "-c", f"{SOURCE}/{file}", "-o", target], name)
    objects |= runner_objects(connection, name)
    libraries = [option for option in command if option.startswith("-l")]
    libraries += [str(path) for path in BACKTRACE[0].glob(BACKTRACE[1])]
    linking = [command[0], *objects, "-o", str(PROGRAM), AS_NEEDED, *libraries, "-lm"]
    run(connection, linking, name, named=objects)
    sys.stdout.buffer.write(PROGRAM.read_bytes())
    sys.stdout.buffer.flush()
    connection.send(b"k")
    connection.receive()
    connection.quit()


def runner_objects(connection: Connection, name: str) -> dict[str, str]:
    """Return object file -> source file of our part; compiled here if this host keeps none."""
    objects = {}
    for target, file in RUNNER.items():
        made = f"{NATIVE}/{target}"
        if not Path(made).exists():
            made = f"/tmp/{target}"  # noqa: S108
            run(connection, [*COMPILE_OURS, "-c", f"{NATIVE}/{file}", "-o", made], name)
        objects[made] = file
    return objects


def write_sources(connection: Connection, name: str, source: bytes) -> list[str]:
    """Write the text, or the files of an archive, for the compiler; return the source files.

    The main program of a generated model (ert_main.c) is left out: here the runner is the main one.
    """
    SOURCE.mkdir()
    OBJECTS.mkdir()
    if not source.startswith(ZIP_MAGIC):
        (SOURCE / name).write_bytes(source)
        return [name]
    try:
        with zipfile.ZipFile(io.BytesIO(source)) as archive:
            archive.extractall(SOURCE)
            names = sorted(archive.namelist())
    except (zipfile.BadZipFile, zlib.error, EOFError, OSError, RuntimeError) as error:
        connection.give_up(b"s", f"{name} cannot be unpacked: {error}.")
    suffixes = (".cpp", ".cc") if "-xc++" in sys.argv else (".c",)
    sources = [file for file in names if file.endswith(suffixes) and CODER_MAIN not in file]
    return sources or connection.give_up(b"s", f"{name} has no file that ends in {suffixes[0]}.")


def with_adapter(files: list[str]) -> list[str]:
    """Return what to compile: with an adapter if this is the generated code of a model."""
    headers = sorted(str(path.relative_to(SOURCE)) for path in SOURCE.rglob("*.h"))
    texts = [(SOURCE / file).read_text("utf-8", "replace") for file in (*headers, *files)]
    text = "\n".join(texts)
    if not looks_generated(text):
        return files
    # A model in a single file declares its types there: the adapter includes the whole file.
    single = not headers
    (SOURCE / ADAPTER).write_text(adapter(text, files if single else headers), encoding="utf-8")
    return [ADAPTER] if single else [*files, ADAPTER]


def run(
    connection: Connection,
    command: list[str],
    name: str,
    *,
    folder: Path | None = None,
    named: Mapping[str, str] = EMPTY,
) -> None:
    """Run one step of the compilation; give up with its messages if it fails.

    `named` maps object files to their source files, for the messages.
    """
    with MESSAGES.open("wb") as messages:
        code = subprocess.call(
            command, stdin=subprocess.DEVNULL, stdout=messages, stderr=messages, cwd=folder
        )
    if not code:
        return
    with MESSAGES.open("rb") as messages:
        text = messages.read(MAX_TEXT_BYTES).decode("utf-8", "replace")
    for path, file in named.items():
        text = text.replace(path, file)
    for ours in OURS:
        text = text.replace(ours, "")
    text = ASSEMBLY.sub(f"{name} (assembly)", text)
    if "Killed signal" in text:
        connection.give_up(b"m", "The compiler exceeded its memory limit.", text)
    connection.give_up(b"s", first_error(text, name), text)


def first_error(text: str, name: str) -> str:
    """Return the first error as one sentence."""
    lines = text.splitlines()
    errors = [line for line in lines if ERROR_LINE.search(line)]
    return (errors or lines or [f"{name} cannot be compiled."])[0]


def main() -> None:
    """Compile with the command before `--`."""
    split = sys.argv.index("--")
    connection = connected(sys.argv[split + 1 :])
    connection.send(b"k")
    compile_source(connection, sys.argv[1:split])
