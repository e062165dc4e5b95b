"""What one language needs inside a box, and the libraries of the host among it."""

import os
from dataclasses import dataclass
from pathlib import Path

LIBRARIES = Path("/usr/lib/x86_64-linux-gnu")  # what native programs in a box can load


@dataclass(frozen=True, slots=True)
class BindMount:
    """A file or folder of the host that the box sees read-only at another path."""

    source: Path
    target: str


@dataclass(frozen=True, slots=True)
class Runtime:
    """The first command of a box, its environment and its read-only files."""

    command: tuple[str, ...]  # three numbers are appended: descriptor, processes, memory [MiB]
    environment: dict[str, str]
    mounts: tuple[BindMount, ...]
    images: bool = False  # whether its programs can be given images


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
