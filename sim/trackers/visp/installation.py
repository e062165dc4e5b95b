"""Whether ViSP's bridge program is on this machine."""

import hashlib
import os
from functools import cache
from pathlib import Path

from seamark.sim.numerics.cache_folder import cache_folder

SOURCE = Path(__file__).parent / "bridge.cpp"
PACKAGE = "libvisp-tt-mi-dev"
REMEDY = f"apt-get install {PACKAGE}, then `python -m seamark.sim.trackers.visp.build`"


@cache
def bridge_path() -> Path:
    """Return the path of the built bridge; its name holds the hash of its source."""
    stamp = hashlib.sha256(SOURCE.read_bytes()).hexdigest()[:16]
    return cache_folder(SOURCE.parent, os.environ) / f"visp-bridge-{stamp}"


def unavailable_reason() -> str:
    """Return why ViSP cannot be used on this machine; empty if it can."""
    if os.access(bridge_path(), os.X_OK):
        return ""
    return f"its bridge program is not built on this machine: {REMEDY}"
