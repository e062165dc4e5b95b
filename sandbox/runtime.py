"""What one language needs inside a box."""

from dataclasses import dataclass
from pathlib import Path


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
    images: bool = False  # whether its programs can be given images: trackers and detectors
