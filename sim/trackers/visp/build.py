"""Builds the bridge to ViSP where its headers are: `python -m seamark.sim.trackers.visp.build`."""

import shutil
import subprocess
import sys

from seamark.sim.trackers.visp.installation import PACKAGE, SOURCE, bridge_path

_LIBRARIES = ("-lvisp_tt_mi", "-lvisp_tt", "-lvisp_core")
_TRIES_S = 120


def build() -> str:
    """Build the bridge if it is not there yet; return why it cannot be, or nothing.

    The file is replaced atomically, so that no incomplete program is ever started.
    """
    if bridge_path().exists():
        return ""
    compiler = shutil.which("g++")
    if compiler is None:
        return "g++ is missing: apt-get install g++"
    bridge_path().parent.mkdir(parents=True, exist_ok=True)
    made = bridge_path().with_suffix(".new")
    command = [compiler, "-O2", "-std=c++17", "-w", "-o", str(made), str(SOURCE), *_LIBRARIES]
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=_TRIES_S, check=False
        )
    except subprocess.TimeoutExpired:
        return f"g++ took longer than {_TRIES_S} s"
    except OSError as error:
        return f"g++ could not be started: {error}"
    if done.returncode != 0:
        first = next(iter(done.stderr.splitlines()), "g++ said nothing")
        return f"ViSP's headers are missing or of another version ({first}): {PACKAGE}"
    made.replace(bridge_path())
    for old in SOURCE.parent.glob("*bridge-*"):  # none in a cache folder
        if old != bridge_path():
            old.unlink()
    return ""


if __name__ == "__main__":
    reason = build()
    if reason:
        sys.exit(f"ViSP is not available: {reason}")
