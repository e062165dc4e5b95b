"""Results of self-tests that are kept, so that the next start of a worker need not repeat them.

A worker that starts tests each language in boxes, for more than a second of CPU time, though hardly
anything ever changes. A test that has passed is kept together with the state of this system and of
all that a box of its language sees: of each file but bytecode the time of the last change that the
kernel has noted, which no program can set. If anything differs, or after a day, the language is
tested again. What has failed is never kept: the remedy may be one that no file shows.

What protects is never kept: `probes` attacks real boxes at every start. Whoever could write a false
result here could as well change the bytecode beside it.
"""

import hashlib
import json
import os
import time
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import asdict
from functools import cache
from pathlib import Path

from seamark.sandbox.isolation.bwrap_command import bubblewrap, library_folders
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.languages import LANGUAGES
from seamark.sandbox.outcome import SandboxBroken
from seamark.sandbox.probing import self_test
from seamark.sandbox.probing.self_test import Component, Result
from seamark.sandbox.runtime import Runtime

SANDBOX = Path(__file__).parents[1]
KEPT = Path(__file__).parent / "__pycache__"  # beside the bytecode, which is kept as long
KEPT_S = 86_400.0  # [s]
BOOT = Path("/proc/sys/kernel/random/boot_id")


class KeptTests:
    """The self-tests of this host; each language is tested if no kept result is valid."""

    def __init__(self, isolation: IsolationLevel, *, kept_in: Path = KEPT) -> None:
        self._isolation, self._kept_in = isolation, kept_in
        self._state_of = cache(state_of)  # languages share most of their files

    def result(self, language: str) -> Result:
        """Return the result of a language's self-test."""
        try:
            state = self._state(language)
        except (SandboxBroken, OSError):  # something is missing: the test says what
            return self_test.tried(language, self._isolation)
        file = self._kept_in / f"self-test-{language}-{self._isolation.name.lower()}.json"
        kept = _read(file, state)
        if kept is None:
            kept = self_test.tried(language, self._isolation)
            if not kept.why_not:
                _write(file, state, kept)
        return kept

    def _state(self, language: str) -> str:
        """Return the state of everything that the self-test depends on."""
        known = LANGUAGES[language]
        compiler = LANGUAGES[known.sample_compiler].compiler
        runtimes = [known.runtime(), *([compiler()] if compiler else [])]
        files = [SANDBOX, Path(bubblewrap()), *library_folders(), *_files(runtimes)]
        system = (os.uname(), os.geteuid(), os.getegid(), _text(BOOT), self._isolation.name)
        told = (known.self_test.upload(), known.self_test.upload_name, known.roles, runtimes)
        return _digest([repr(system), repr(told), *map(self._state_of, dict.fromkeys(files))])


def state_of(path: Path) -> str:
    """Return what changes with any file in a folder, or with a single file."""
    return _digest(sorted(_states(path)))


def _states(path: Path) -> Iterator[str]:
    """Yield a line for a file, or for a folder and each thing in it."""
    yield _line(path, path.stat())
    folders = [path] if path.is_dir() else []
    for folder in folders:  # grows during the iteration
        with os.scandir(folder) as entries:
            for entry in entries:
                if entry.name == KEPT.name:
                    continue
                yield _line(entry, entry.stat(follow_symlinks=False))
                if entry.is_dir(follow_symlinks=False):
                    folders.append(Path(entry.path))


def _line(path: "os.PathLike[str]", status: os.stat_result) -> str:
    return f"{os.fspath(path)} {status.st_ino} {status.st_size} {status.st_ctime_ns}"


def _files(runtimes: Iterable[Runtime]) -> Iterator[Path]:
    for runtime in runtimes:
        yield from (mount.source for mount in runtime.mounts)


def _digest(lines: Iterable[str]) -> str:
    return hashlib.sha256("\n".join(lines).encode("utf-8", "surrogateescape")).hexdigest()


def _text(path: Path) -> str:
    return path.read_text(encoding="utf-8") if path.exists() else ""


def _read(file: Path, state: str) -> Result | None:
    """Return a kept result; None if there is none of this state."""
    try:
        kept = json.loads(file.read_text(encoding="utf-8"))
        is_valid = kept["state"] == state and 0.0 <= time.time() - kept["tested_at"] < KEPT_S
        return Result("", tuple(Component(**one) for one in kept["contents"])) if is_valid else None
    except (OSError, ValueError, TypeError, KeyError):
        return None


def _write(file: Path, state: str, result: Result) -> None:
    contents = [asdict(component) for component in result.contents]
    text = json.dumps({"state": state, "tested_at": time.time(), "contents": contents})
    partial = file.with_suffix(f".{os.getpid()}")  # several workers may start at once
    with suppress(OSError):  # it is tested again
        file.parent.mkdir(exist_ok=True)
        partial.write_text(text, encoding="utf-8")
        partial.rename(file)
