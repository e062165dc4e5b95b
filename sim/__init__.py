"""The simulator: vehicle, water, camera, trackers, controllers, benchmarks. Runs alone."""

import hashlib
import os
from pathlib import Path

_SOURCES = Path(__file__).parent


def _name_compiled_code_after_its_sources() -> None:
    """Give Numba's cache a folder of its own for each state of the sources.

    Numba watches the file of the calling function alone: after a change in a file that it calls
    into, the cache would silently go on with the old code, and results would be of neither version.
    Has to happen before Numba is imported, which reads the variable once.
    """
    digest = hashlib.sha256()
    for path in sorted(_SOURCES.rglob("*.py")):
        digest.update(path.relative_to(_SOURCES).as_posix().encode())
        digest.update(path.read_bytes())
    name = f"numba-{digest.hexdigest()[:16]}"
    beside = _SOURCES / "__pycache__"
    own = beside if os.access(_SOURCES, os.W_OK) else Path.home() / ".cache" / "seamark"
    base = Path(os.environ.get("NUMBA_CACHE_DIR") or own)
    if base.name != name:  # else inherited from the process that started this one
        os.environ["NUMBA_CACHE_DIR"] = str(base / name)


_name_compiled_code_after_its_sources()
