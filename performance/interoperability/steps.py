"""Other programs as steps of a check."""

import subprocess
from collections.abc import Sequence
from pathlib import Path

TIMEOUT_S = 600


class Failed(Exception):
    """A step failed; the text says why."""


def run(command: Sequence[str], folder: Path) -> str:
    """Return what a command prints; raises Failed if it fails."""
    done = subprocess.run(
        command, cwd=folder, stdout=subprocess.PIPE, text=True, check=False, timeout=TIMEOUT_S
    )
    if done.returncode != 0:
        raise Failed(f"{Path(command[0]).name} ended with {done.returncode}")
    return done.stdout
