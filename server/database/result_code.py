"""What decides the results that a process computes: its code, and the versions of its libraries.

Two workers with the same text give every run the same result. The version of Seamark is not part of
it: one that only changes pages computes as the one before.
"""

import hashlib
import json
from functools import cache
from pathlib import Path

from seamark.sim.recording.manifest import code_sha256, versions

_ROOT = Path(__file__).parents[2]
_FOLDERS = ("programs", "sandbox", "worker/evaluation")  # beside the simulator
_NOT_COMPUTING = "seamark"


@cache
def result_code() -> str:
    """Return the code and the versions as JSON, those of the first call in this process."""
    decisive = {name: value for name, value in versions().items() if name != _NOT_COMPUTING}
    return json.dumps({"code": _code_sha256(), **decisive}, sort_keys=True)


def difference(ours: str, theirs: str) -> str:
    """Return in words what differs between two such texts."""
    mine, other = json.loads(ours), json.loads(theirs)
    names = sorted(name for name in {*mine, *other} if mine.get(name) != other.get(name))
    return ", ".join(
        "other code" if name == "code" else f"{name} {mine.get(name)} instead of {other.get(name)}"
        for name in names
    )


def _code_sha256() -> str:
    total = hashlib.sha256(code_sha256().encode())
    for folder in _FOLDERS:
        for path in sorted((_ROOT / folder).rglob("*")):
            if path.is_file() and "__pycache__" not in path.parts:
                total.update(path.relative_to(_ROOT).as_posix().encode() + b"\0")
                total.update(hashlib.sha256(path.read_bytes()).digest())
    return total.hexdigest()
