"""Compiles an FMU that has sources but no binary for this platform; returns others unchanged.

Arguments: the compiler's command, then `--` and those of `connected`.
"""

import io
import sys
import zipfile
from pathlib import Path
from typing import NoReturn

from ...c_family.inside.compile_source import run
from ...inside.connection import Connection, connected
from .build import build_of
from .description import DESCRIPTION, Description, Unusable, checked, read

FOLDER = Path("/tmp/fmu")  # noqa: S108  (inside the box)


def compile_sources(connection: Connection, command: list[str]) -> NoReturn:
    """Compile the FMU if it needs it; write it to standard output."""
    header, data = connection.program()
    name = str(header["filename"])
    try:
        description = read(data)
        if description.library not in description.archive.namelist():
            build = build_of(description)
            if not build.sources:
                checked(description, name)
            parts = [*build.options, *build.sources]
            data = with_library(connection, description, [*command, *parts], name)
    except Unusable as reason:
        connection.give_up(b"s", str(reason))
    sys.stdout.buffer.write(data)
    sys.stdout.buffer.flush()
    connection.send(b"k")
    connection.receive()
    connection.quit()


def with_library(
    connection: Connection, description: Description, command: list[str], name: str
) -> bytes:
    """Return the FMU with a binary compiled from its sources."""
    archive = description.archive
    for member in archive.namelist():
        if member.startswith("sources/"):
            archive.extract(member, FOLDER)
    library = FOLDER / "compiled.so"
    run(connection, [*command, "-o", str(library), "-lm"], name, folder=str(FOLDER))
    compiled = io.BytesIO()
    with zipfile.ZipFile(compiled, "w") as whole:
        for member in archive.namelist():
            if member == DESCRIPTION or member.startswith(("resources/", "extra/")):
                whole.writestr(member, archive.read(member))
        whole.writestr(description.library, library.read_bytes())
    return compiled.getvalue()


def main() -> None:
    """Report that the box is up, wait for the FMU."""
    split = sys.argv.index("--")
    connection = connected(sys.argv[split + 1 :])
    connection.send(b"k")
    compile_sources(connection, sys.argv[1:split])
