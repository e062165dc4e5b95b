"""What takes part in a benchmark: a built-in solution, or a program that is read as an upload."""

from __future__ import annotations

import atexit
import difflib
import shutil
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from seamark.cli.extras import has_simulator
from seamark.drafts import replace_file
from seamark.failures import PlatformFailed, ProgramFailed, UsageRefused

if TYPE_CHECKING:
    from seamark.programs.preparation import PreparedProgram
    from seamark.sandbox.isolation.level import IsolationLevel
    from seamark.sandbox.probing.probes import IsolationReport

    FindIsolation = Callable[[str], IsolationLevel]  # for runs of a benchmark


def choose(controller: str | None, benchmark: str) -> tuple[str, Path | None]:
    """Return the name of a solution and its file; None for a built-in one.

    A folder is packed into an archive. The default is the first built-in solution of the benchmark.
    A benchmark that this version does not know may be one of a newer server.

    Raises
    ------
    UsageRefused
        It is neither a file, a folder nor built in, or the benchmark does not support its language.
    """
    if not has_simulator():
        return _choose_unchecked(controller)
    from seamark.sim import registry

    known = benchmark if benchmark in registry.BENCHMARKS else registry.DEFAULT_BENCHMARK
    entry = registry.benchmark(known)
    built_in = list(entry.built_in)
    if controller is None or controller in {*built_in, *entry.reference_built_in}:
        return controller or built_in[0], None
    path = file_of(Path(controller))
    if path.is_file():
        _check_language(path, entry.role)
        return controller, path
    near = difflib.get_close_matches(controller, built_in, n=1)
    hint = f" Did you mean {near[0]}?" if near else ""
    raise UsageRefused(
        f"{controller} is neither a file or folder nor a built-in {entry.role} "
        f"({', '.join(built_in)}).{hint}"
    )


def _choose_unchecked(controller: str | None) -> tuple[str, Path | None]:
    """Return the name of a solution and its file where only the server knows what is built in."""
    if controller is None:
        raise UsageRefused("Name a file or a built-in solution with --controller.")
    path = file_of(Path(controller))
    if path.suffix and not path.is_file():
        raise UsageRefused(f"There is no file {controller}.")
    return controller, path if path.is_file() else None


def file_of(path: Path) -> Path:
    """Return the file of a program: a folder is packed into an archive until the process ends.

    Raises
    ------
    UsageRefused
        The folder cannot be read, or would be no archive that can be uploaded.
    """
    if not path.is_dir():
        return path
    from seamark.programs import archives
    from seamark.sandbox.limits import Limits

    try:
        content = archives.of_folder(path, limits=Limits())
    except archives.ArchiveRefused as reason:
        raise UsageRefused(f"{path}: {reason}") from None
    except OSError as error:
        raise UsageRefused(f"{error.filename} cannot be read: {error.strerror}.") from None
    target = Path(tempfile.mkdtemp(prefix="seamark-"))
    atexit.register(shutil.rmtree, target, ignore_errors=True)
    packed = target / f"{path.resolve().name or 'program'}.zip"
    replace_file(packed, content)
    return packed


def choose_parts(files: Mapping[str, Path], *, benchmark: str) -> dict[str, Path]:
    """Return role -> file of the further programs of a run; a folder is packed into an archive.

    Raises
    ------
    UsageRefused
        The benchmark has no such part, or does not support the language of the file.
    """
    if not has_simulator():
        return {role: file_of(file) for role, file in files.items()}
    from seamark.programs import parts
    from seamark.sim import registry

    chosen: dict[str, Path] = {}
    for role, file in files.items():
        known = benchmark in registry.BENCHMARKS  # else it may be one of a newer server
        if known and (refusal := parts.refusal(registry.benchmark(benchmark), role)):
            raise UsageRefused(refusal)
        chosen[role] = file_of(file)
        if not chosen[role].is_file():
            raise UsageRefused(f"There is no file {file}.")
        _check_language(chosen[role], role)
    return chosen


def prepare_parts(files: Mapping[str, Path], *, benchmark: str) -> dict[str, PreparedProgram]:
    """Return role -> program of the further programs of a run.

    Raises
    ------
    UsageRefused
        As `choose_parts`, or a file cannot be read.
    ProgramFailed
        The server would refuse an upload of it.
    """
    chosen = choose_parts(files, benchmark=benchmark)
    return {
        role: prepare_valid(path, benchmark=benchmark, role=role) for role, path in chosen.items()
    }


def _check_language(path: Path, role: str) -> None:
    from seamark.sandbox.languages import language_of, role_refusal

    name = language_of(path.name)
    if name is not None and (refusal := role_refusal(name, role)):
        raise UsageRefused(f"{path}: {refusal}")


def prepare(path: Path, *, benchmark: str, role: str = "") -> PreparedProgram:
    """Return the program in a file, read and checked as an upload of it.

    Parameters
    ----------
    role
        What it is in the benchmark; empty: what the benchmark evaluates.

    Raises
    ------
    UsageRefused
        The file cannot be read, or its type is unknown.
    ProgramFailed
        The server would refuse an upload of it.
    """
    from seamark.programs.archives import is_archive
    from seamark.programs.preparation import UploadRejected
    from seamark.programs.preparation import prepare as prepare_upload
    from seamark.sandbox.languages import language_of
    from seamark.sim import registry

    if language_of(path.name) is None and not is_archive(path.name):
        raise UsageRefused(f"{path}: files of this type belong to no supported language.")
    try:
        role = role or registry.benchmark(benchmark).role
        return prepare_upload(path.read_bytes(), path.name, role=role)
    except OSError as error:
        raise UsageRefused(f"{path} cannot be read: {error.strerror}.") from None
    except UploadRejected as reason:
        raise ProgramFailed(str(reason)) from None


def prepare_valid(path: Path, *, benchmark: str, role: str = "") -> PreparedProgram:
    """Return the program in a file as `prepare`; raise ProgramFailed if it has diagnostics."""
    prepared = prepare(path, benchmark=benchmark, role=role)
    if prepared.diagnostics:
        raise ProgramFailed("\n".join(diagnostic.text() for diagnostic in prepared.diagnostics))
    return prepared


@cache  # trying takes most of a second, and a search and its validation both ask
def isolation_level() -> IsolationLevel:
    """Return the isolation level of sandboxes on this machine; PlatformFailed if it is none."""
    from seamark.sandbox.probing.probes import probe

    return _sufficient(probe())


@contextmanager
def probing(*, needed: bool) -> Iterator[FindIsolation]:
    """Find the isolation level of sandboxes beside what the caller does, if that is needed.

    Provides the function that loads what runs of a benchmark need, and returns the level; NONE if
    it is not needed. Probing takes as long as loading the simulator, so that a command which begins
    with this loses no time.

    Raises
    ------
    PlatformFailed
        From the function: programs cannot run on this machine.
    """
    from seamark.sandbox.isolation.level import IsolationLevel
    from seamark.sandbox.probing import beside

    if not needed:
        yield lambda _benchmark: IsolationLevel.NONE
        return
    with beside.probing() as report:

        def level(benchmark: str) -> IsolationLevel:
            from seamark.sim.engine.warm_up import warm_up_benchmark

            warm_up_benchmark(benchmark)
            return _sufficient(report())

        yield level


def _sufficient(isolation: IsolationReport) -> IsolationLevel:
    from seamark.sandbox.isolation.level import IsolationLevel

    if isolation.level is IsolationLevel.NONE:
        raise PlatformFailed(
            f"Programs cannot run on this machine: {isolation.sentence()}. `seamark doctor` says "
            "how to fix it."
        )
    return isolation.level


@contextmanager
def sandbox_failures_explained() -> Iterator[None]:
    """Raise PlatformFailed where the sandbox fails."""
    from seamark.sandbox.outcome import SandboxBroken

    try:
        yield
    except SandboxBroken as error:
        raise PlatformFailed(
            f"The sandbox failed: {error}. `seamark doctor` checks what this machine supports."
        ) from None
