"""Starts GNU Octave, which can neither open a socket nor pack a message of the protocol.

Becomes Octave, which runs runner.m; that starts the relay (relay.py) with two pipes as its standard
input and output. The main process of the box is Octave itself, so that its exit is the program's,
and what the program prints is not mixed with answers.

Arguments: `--`, then those of `connected`. Each import is part of every start: hence so few.
"""

import os
import sys

from ...inside.connection import connected

FOLDER = "/tmp/program"  # noqa: S108  (inside the box)
# The file of a program of one text: it exists from the start, so that Octave has it in its cache.
PROGRAM_FILE = "seamark_program.m"
OCTAVE = (
    *("/usr/bin/octave-cli", "--norc", "--no-history", "--no-gui", "--no-line-editing"),
    *("--quiet", "/box/octave/runner.m"),
)


def main() -> None:
    """Become Octave, which keeps the socket and the images for the relay."""
    split = sys.orig_argv.index("--")
    connection = connected(sys.orig_argv[split + 1 :], inherited=True, images=True)
    relay = [word.replace(".octave import", ".relay import") for word in sys.orig_argv[:split]]
    relay += ["--", str(connection.descriptor), "0", "0"]
    os.mkdir(FOLDER)
    os.close(os.open(f"{FOLDER}/{PROGRAM_FILE}", os.O_WRONLY | os.O_CREAT, 0o666))
    os.execve(OCTAVE[0], [*OCTAVE, *relay], dict(os.environ))  # noqa: S606
