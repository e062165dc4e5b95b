"""Compiles an FMU that brings sources and no program for this machine; passes on others.

Arguments: `compile` with the compiler's command, then `--` and the numbers of the connection.
"""

import io
import sys
import zipfile
from pathlib import Path
from typing import NoReturn

from .connection import Connection, connected
from .fmu_build import build_of
from .fmu_description import DESCRIPTION, Description, Unusable, checked, read
from .native import run

FOLDER = Path("/tmp/fmu")  # noqa: S108  (inside the box)


def compile_sources(connection: Connection, command: list[str]) -> NoReturn:
    """Compile an FMU that brings sources and no program for this machine; pass on others."""
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
    connection.leave()


def with_library(
    connection: Connection, description: Description, command: list[str], name: str
) -> bytes:
    """Return the FMU with a program made of its sources."""
    archive = description.archive
    for member in archive.namelist():
        if member.startswith("sources/"):
            archive.extract(member, FOLDER)
    library = FOLDER / "made.so"
    run(connection, [*command, "-o", str(library), "-lm"], name, folder=FOLDER)
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w") as whole:
        for member in archive.namelist():
            if member == DESCRIPTION or member.startswith(("resources/", "extra/")):
                whole.writestr(member, archive.read(member))
        whole.writestr(description.library, library.read_bytes())
    return made.getvalue()


def main() -> None:
    """Do it."""
    split = sys.argv.index("--")
    connection = connected(sys.argv[split + 1 :])
    connection.send(b"k")
    compile_sources(connection, sys.argv[2:split])
