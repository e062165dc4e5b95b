"""What a box has to know about a programming language."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, slots=True)
class Bind:
    """A file or folder of the host that the box sees read-only under another name."""

    source: Path
    target: str


@dataclass(frozen=True, slots=True)
class Runtime:
    """What one language needs inside a box: command, environment and read-only files."""

    command: tuple[str, ...]  # the number of the protocol's descriptor is appended
    environment: dict[str, str]
    binds: tuple[Bind, ...]
    images: bool = False  # whether its programs may be shown images: trackers and detectors


@dataclass(frozen=True, slots=True)
class Calls:
    """What the calls of a program are named to its owner when they take too long."""

    start: str
    reset: str
    step: str


PYTHON_CALLS = Calls("The program (import and __init__)", "reset(level)", "step(observation)")


@dataclass(frozen=True, slots=True)
class Language:
    """One language: its name, its label, the suffixes of its files, how it runs in a box.

    With a `compiler`, what runs is not the text but what comes out of a box of the compiler's own
    (see sandbox/compilation.py).
    """

    name: str
    label: str
    suffixes: tuple[str, ...]
    runtime: Callable[[], Runtime]  # found on the host when first asked; SandboxBroken if missing
    self_test: str | Callable[[], bytes]  # what it must answer is in sandbox/probing/self_test.py
    compiler: Callable[[], Runtime] | None = None
    calls: Calls = PYTHON_CALLS
    mains: tuple[str, ...] = ()  # files at the top of an archive that make it one of this language
    packed: bool = False  # its files are zip archives themselves
    roles: tuple[str, ...] = ("controller",)  # what its programs may be
    refusal: Callable[[bytes], str] | None = None  # its files are no text: why one cannot be run
    tested_by: str = ""  # the language whose compiler makes the self-test, if not its own
    packages: tuple[str, ...] = ()  # of Debian, beside what Seamark itself brings

    @property
    def is_text(self) -> bool:
        """Whether its files are texts that people write."""
        return not self.packed and self.refusal is None

    @property
    def remedy(self) -> str:
        """What to do where its self-test does not pass."""
        if not self.packages:
            return "`./run` sets up all that it needs"
        return f"apt-get install {' '.join(self.packages)}"
