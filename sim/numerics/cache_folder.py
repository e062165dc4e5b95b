"""Where code that is compiled on this machine is kept.

In a checkout that is beside the sources, where `git clean` finds it. An installed package stays as
it was installed: pip would leave behind what it did not put there, and the folder may belong to
root. Its code goes to the user's cache folder, under names that hold a hash of the sources, so that
versions beside each other never use each other's.

Importing this module loads neither Numba nor NumPy.
"""

import os
from collections.abc import Mapping
from pathlib import Path

_INSTALLED = {"site-packages", "dist-packages"}  # names of the folders that pip installs into


def cache_folder(beside: Path, environ: Mapping[str, str]) -> Path:
    """Return a folder of the sources where it may be written to, else that of the user's cache."""
    if os.access(beside, os.W_OK) and not _INSTALLED & set(beside.parts):
        return beside
    configured = Path(environ.get("XDG_CACHE_HOME", ""))
    # The XDG base directory specification says that a relative path has to be ignored.
    return (configured if configured.is_absolute() else Path.home() / ".cache") / "seamark"
