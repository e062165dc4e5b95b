"""Runs inside a box: writes a compiled program to a file and becomes it.

Arguments: `--`, then those of `connected`. Each import is part of every start: hence so few.
"""

import json
import os
import sys
from collections.abc import Iterator

from ...inside.connection import Connection, connected

TYPE_CHECKING = False  # `typing` takes a millisecond
if TYPE_CHECKING:
    from typing import Any, NoReturn

PROGRAM = "/tmp/program"  # noqa: S108  (inside the box)
START_FILE = "/tmp/begin"  # noqa: S108  (read and removed by the runner)


def start(connection: Connection) -> "NoReturn":
    """Become the program; layout and configuration are in a file."""
    header, program = connection.program()
    images = header.get("images")  # of a tracker or detector, or of a controller that gets them
    connection.close_others(*([images["descriptor"]] if images else []))
    lines = [f"{name} {count}" for name, count in layout_of(header)]
    lines += [f"joint_limit {limit!r}" for limit in header["layout"].get("joint_limits", ())]
    lines += [f"camera {name} {h} {w}" for name, h, w in header["layout"].get("images", ())]
    write(START_FILE, "\n".join([*lines, json.dumps(header["config"])]).encode("ascii"), 0o600)
    write(PROGRAM, program, 0o700)
    arguments = [str(connection.descriptor), str(connection.sequence), START_FILE]
    try:
        os.execve(PROGRAM, [str(header["filename"]), *arguments], dict(os.environ))  # noqa: S606
    except OSError as error:
        connection.give_up(b"u", f"The compiled program cannot be started: {error.strerror}.")


def write(path: str, data: bytes, mode: int) -> None:
    """Create a file."""
    with open(path, "xb", opener=lambda name, flags: os.open(name, flags, mode)) as file:
        file.write(data)


def layout_of(header: "dict[str, Any]") -> Iterator[tuple[str, int]]:
    """Yield the names and counts that a program reads first; keep the images' descriptor open.

    A controller gets the layout of its observation; the others their role. The images' memory
    follows where there is one.
    """
    role, images = header["layout"].get("role", "controller"), header.get("images")
    if role == "controller":
        yield from header["layout"]["observation"]
    else:
        yield role, 0
    if images is None:
        return
    os.set_inheritable(images["descriptor"], True)
    yield "images_descriptor", images["descriptor"]
    yield "images_bytes", images["bytes"]


def main() -> None:
    """Report that the box is up, wait for the program."""
    split = sys.argv.index("--")
    connection = connected(sys.argv[split + 1 :], inherited=True, images=True)
    connection.send(b"k")
    start(connection)
