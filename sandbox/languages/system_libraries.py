"""Libraries of the host that native programs in a box can load."""

import os
from pathlib import Path

from seamark.sandbox.runtime import BindMount

LIBRARIES = Path("/usr/lib/x86_64-linux-gnu")


def alternatives(libraries: Path = LIBRARIES) -> list[BindMount]:
    """Return the libraries that Debian links through /etc/alternatives, which a box does not have.

    BLAS and LAPACK, which Octave and OpenCV need. Which ones there are depends on the host's
    choice: OpenBLAS brings a third one.
    """
    links = [link for link in sorted(libraries.glob("*.so.*")) if link.is_symlink()]
    targets = [(link, os.readlink(link)) for link in links if link.exists()]
    return [
        BindMount(Path(os.path.realpath(link)), target)
        for link, target in targets
        if target.startswith("/etc/")
    ]
