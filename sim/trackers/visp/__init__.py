"""ViSP's template trackers, where Debian's library is installed: by way of a program of our own.

ViSP is licensed under the GPL, so it stays in a process of its own (bridge.cpp) that is built on
this machine and never handed on. Importing this package is light: forms ask it whether ViSP is
here.
"""

import hashlib
import os
from functools import cache
from pathlib import Path

SOURCE = Path(__file__).parent / "bridge.cpp"
PACKAGE = "libvisp-tt-mi-dev"
REMEDY = f"apt-get install {PACKAGE}, then ./run builds the bridge"


@cache
def program() -> Path:
    """Return where the built bridge is: its name says from which source it was made."""
    stamp = hashlib.sha256(SOURCE.read_bytes()).hexdigest()[:16]
    return SOURCE.with_name(f"bridge-{stamp}")


def why_not() -> str:
    """Return why ViSP cannot be used on this machine; empty if it can."""
    if os.access(program(), os.X_OK):
        return ""
    return f"its bridge program is not built on this machine: {REMEDY}"
