"""Lets GNU Octave speak the protocol: Octave can neither open a socket nor pack a frame.

Becomes Octave, which runs runner.m; that starts the relay (octave_relay.py) with two pipes as its
standard input and output. The main process of the box is Octave itself, so that its end is the
program's, and what the program prints is not mixed with answers.

Arguments: `--` and the numbers of the connection.
"""

import os
import sys
from pathlib import Path

from .connection import connected

FOLDER = Path("/tmp/program")  # noqa: S108  (inside the box)
# The name of a program that is one file: there from the start, so that Octave knows it beforehand.
PLACED = "seamark_program.m"
OCTAVE = (
    *("/usr/bin/octave-cli", "--norc", "--no-history", "--no-gui", "--no-line-editing"),
    *("--quiet", "/box/octave/runner.m"),
)


def main() -> None:
    """Become Octave, which keeps connection and images for the relay."""
    split = sys.orig_argv.index("--")
    connection = connected(sys.orig_argv[split + 1 :], inherited=True, images=True)
    relay = [word.replace(".octave ", ".octave_relay ") for word in sys.orig_argv[:split]]
    relay += ["--", str(connection.fd), "0", "0"]
    FOLDER.mkdir()
    (FOLDER / PLACED).touch()
    os.execve(OCTAVE[0], [*OCTAVE, *relay], dict(os.environ))  # noqa: S606
