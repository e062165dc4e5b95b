"""Programs of the participant on the command line: read and checked as uploads are."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from seamark.failures import PlatformFailed, ProgramFailed, UsageRefused

if TYPE_CHECKING:
    from seamark.sandbox.isolation.level import IsolationLevel
    from seamark.server.programs.store import PreparedProgram


def program_of(path: Path, *, benchmark: str) -> PreparedProgram:
    """Return the program in a file as an upload of it would be kept.

    Raises
    ------
    UsageRefused
        The file cannot be read or is of no known kind.
    ProgramFailed
        An upload of it would be refused.
    """
    prepared = prepared_of(path, benchmark=benchmark)
    if prepared.diagnostics:
        raise ProgramFailed("\n".join(diagnostic.text() for diagnostic in prepared.diagnostics))
    return prepared


def prepared_of(path: Path, *, benchmark: str) -> PreparedProgram:
    """Return the program in a file with its diagnostics; raises as `program_of`."""
    from seamark.sandbox.languages import language_of
    from seamark.server.programs.archives import is_archive
    from seamark.server.programs.store import UploadRejected, prepare
    from seamark.sim import registry

    if language_of(path.name) is None and not is_archive(path.name):
        raise UsageRefused(f"{path}: no language is known for this kind of file.")
    try:
        return prepare(path.read_bytes(), path.name, role=registry.benchmark(benchmark).role)
    except OSError as error:
        raise UsageRefused(f"{path} cannot be read: {error.strerror}.") from None
    except UploadRejected as reason:
        raise ProgramFailed(str(reason)) from None


def isolation_level() -> IsolationLevel:
    """Return at which level boxes can be made here; PlatformFailed if at none."""
    from seamark.sandbox.isolation.level import IsolationLevel
    from seamark.sandbox.probing.probes import probe

    found = probe()
    if found.level is IsolationLevel.NONE:
        raise PlatformFailed(
            f"Programs cannot be run here: {found.sentence()}. `seamark doctor` says how to "
            "mend it."
        )
    return found.level
