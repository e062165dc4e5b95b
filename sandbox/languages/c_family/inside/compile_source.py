"""Runs inside a box: compiles the user's source.

Arguments: the compiler's command, then `--`; then the number of the socket's descriptor, and the
limits of processes and memory [MiB] to set here, 0 if control groups enforce them. Each import is
part of every start: hence so few.
"""

import glob
import os
import re
import signal
import sys
from collections.abc import Mapping

from ...inside.connection import MAX_TEXT_BYTES, Connection, connected
from .step_functions import looks_generated

NATIVE = "/box/native"
SOURCE, OBJECTS = "/tmp/source", "/tmp/objects"  # noqa: S108
COMPILE_OURS = ("/usr/bin/gcc", "-O2", "-std=c11")
RUNNER = {"runner.o": "runner.c", "crash.o": "crash.c"}
BACKTRACE = "/usr/lib/gcc/*/*/libbacktrace.a"
ZIP_MAGIC, CODER_MAIN, ADAPTER = b"PK\x03\x04", "ert_main", "seamark_connection.c"
PROGRAM, MESSAGES = "/tmp/program", "/tmp/messages"  # noqa: S108
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
    files = with_adapter(connection, files)
    objects = {f"{OBJECTS}/{index}.o": file for index, file in enumerate(files)}
    for target, file in objects.items():
        run(connection, [*command, f"-I{SOURCE}", "-c", f"{SOURCE}/{file}", "-o", target], name)
    objects |= runner_objects(connection, name)
    libraries = [option for option in command if option.startswith("-l")]
    libraries += glob.glob(BACKTRACE)
    linking = [command[0], *objects, "-o", PROGRAM, AS_NEEDED, *libraries, "-lm"]
    run(connection, linking, name, named=objects)
    with open(PROGRAM, "rb") as program:
        sys.stdout.buffer.write(program.read())
    sys.stdout.buffer.flush()
    connection.send(b"k")
    connection.receive()
    connection.quit()


def runner_objects(connection: Connection, name: str) -> dict[str, str]:
    """Return object file -> source file of our part; compiled here if this host keeps none."""
    objects = {}
    for target, file in RUNNER.items():
        made = f"{NATIVE}/{target}"
        if not os.path.exists(made):
            made = f"/tmp/{target}"  # noqa: S108
            run(connection, [*COMPILE_OURS, "-c", f"{NATIVE}/{file}", "-o", made], name)
        objects[made] = file
    return objects


def write_sources(connection: Connection, name: str, source: bytes) -> list[str]:
    """Write the text, or the files of an archive, for the compiler; return the source files.

    The main program of a generated model (ert_main.c) is left out: here the runner is the main one.
    """
    os.mkdir(SOURCE)
    os.mkdir(OBJECTS)
    if not source.startswith(ZIP_MAGIC):
        write(f"{SOURCE}/{name}", source)
        return [name]
    import io  # noqa: PLC0415
    import zipfile  # noqa: PLC0415  (6 ms that a program of one file does not need)
    import zlib  # noqa: PLC0415

    try:
        with zipfile.ZipFile(io.BytesIO(source)) as archive:
            archive.extractall(SOURCE)
            names = sorted(archive.namelist())
    except (zipfile.BadZipFile, zlib.error, EOFError, OSError, RuntimeError) as error:
        connection.give_up(b"s", f"{name} cannot be unpacked: {error}.")
    suffixes = (".cpp", ".cc") if "-xc++" in sys.argv else (".c",)
    sources = [file for file in names if file.endswith(suffixes) and CODER_MAIN not in file]
    return sources or connection.give_up(b"s", f"{name} has no file that ends in {suffixes[0]}.")


def with_adapter(connection: Connection, files: list[str]) -> list[str]:
    """Return what to compile: with an adapter if this is the generated code of a model."""
    headers = sorted(glob.glob("**/*.h", root_dir=SOURCE, recursive=True, include_hidden=True))
    texts = [text_of(f"{SOURCE}/{file}") for file in (*headers, *files)]
    text = "\n".join(texts)
    if not looks_generated(text):
        return files
    from .embedded_coder import Unfit, adapter  # noqa: PLC0415  (5 ms that few programs need)

    # A model in a single file declares its types there: the adapter includes the whole file.
    single = not headers
    try:
        written = adapter(text, files if single else headers)
    except Unfit as reason:
        connection.give_up(b"s", str(reason))
    write(f"{SOURCE}/{ADAPTER}", written.encode())
    return [ADAPTER] if single else [*files, ADAPTER]


def run(
    connection: Connection,
    command: list[str],
    name: str,
    *,
    folder: str | None = None,
    named: Mapping[str, str] = EMPTY,
) -> None:
    """Run one step of the compilation; give up with its messages if it fails.

    `named` maps object files to their source files, for the messages.
    """
    if folder is not None:
        os.chdir(folder)
    with open(MESSAGES, "wb") as messages:
        status = ended(command, messages.fileno())
    if not status:
        return
    with open(MESSAGES, "rb") as messages:
        text = messages.read(MAX_TEXT_BYTES).decode("utf-8", "replace")
    for path, file in named.items():
        text = text.replace(path, file)
    for ours in OURS:
        text = text.replace(ours, "")
    text = ASSEMBLY.sub(f"{name} (assembly)", text)
    if "Killed signal" in text:
        connection.give_up(b"m", "The compiler exceeded its memory limit.", text)
    connection.give_up(b"s", first_error(text, name), text)


def ended(command: list[str], messages: int) -> int:
    """Run a program to its end, without input; return its status. `subprocess` takes 4 ms."""
    actions = (
        (os.POSIX_SPAWN_OPEN, 0, os.devnull, os.O_RDONLY, 0),
        (os.POSIX_SPAWN_DUP2, messages, 1),
        (os.POSIX_SPAWN_DUP2, messages, 2),
    )
    default = (signal.SIGPIPE, signal.SIGXFSZ)  # this interpreter ignores them
    pid = os.posix_spawn(command[0], command, os.environ, file_actions=actions, setsigdef=default)
    return os.waitpid(pid, 0)[1]


def text_of(path: str) -> str:
    """Return the text of a file."""
    with open(path, encoding="utf-8", errors="replace") as file:
        return file.read()


def write(path: str, data: bytes) -> None:
    """Write bytes to a file."""
    with open(path, "wb") as file:
        file.write(data)


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
