"""Where Numba keeps compiled code: a folder for each state of the sources that it was made of.

Numba watches the file of the compiled function alone. After a change in a file that it calls into,
the cache would silently go on with the old code, and results would be of neither version. So a
function's folder is named after its own file and all files of `sim` that this one imports, also by
way of others. A change compiles anew what depends on it and nothing else.

Numba imports this module by name (NUMBA_CACHE_LOCATOR_CLASSES), set in `sim/__init__.py`.
"""

import functools
import hashlib
import os
from collections.abc import Callable, Iterator
from modulefinder import ModuleFinder
from pathlib import Path
from types import CodeType
from typing import Self

from numba.core.caching import _CacheLocator

ROOT = Path(__file__).resolve().parents[2]  # the folder that holds `sim`
_FINDER = ModuleFinder()
_OF_THIS_USER = Path.home() / ".cache" / "seamark"


class NamedAfterSources(_CacheLocator):
    """Numba's cache locator for the functions of one file of `sim`."""

    def __init__(self, file: Path, line: int) -> None:
        self._stamp = stamp(file, ROOT)
        self._line = line
        beside = ROOT / "sim"
        own = beside / "__pycache__" if os.access(beside, os.W_OK) else _OF_THIS_USER
        base = Path(os.environ.get("NUMBA_CACHE_DIR") or own)
        self._folder = base / f"numba-{file.stem}-{self._stamp[:16]}"

    @classmethod
    def from_function(cls, function: Callable[..., object], file: str) -> Self | None:
        """Return the locator of a compiled function; None for a function that is not of `sim`."""
        path = Path(file).resolve()
        if not path.is_relative_to(ROOT / "sim"):
            return None
        locator = cls(path, function.__code__.co_firstlineno)
        locator.ensure_cache_path()  # type: ignore[no-untyped-call] # numba has no types
        return locator

    def get_cache_path(self) -> str:
        """Return the folder that holds the function's compiled code."""
        return str(self._folder)

    def get_source_stamp(self) -> str:
        """Return what has to be the same for compiled code to be used."""
        return self._stamp

    def get_disambiguator(self) -> str:
        """Return what tells functions of one name in one file apart."""
        return str(self._line)


@functools.cache
def stamp(file: Path, root: Path) -> str:
    """Return the SHA-256 over a source file and all files below `root` that it imports."""
    digest = hashlib.sha256()
    for path in sorted(_closure(file, root)):
        digest.update(path.relative_to(root).as_posix().encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()


def _closure(file: Path, root: Path) -> set[Path]:
    """Return a file and all files that it imports, directly or by way of others."""
    known: set[Path] = set()
    waiting = [file]
    while waiting:
        path = waiting.pop()
        if path not in known:
            known.add(path)
            waiting.extend(_imported(path, root))
    return known


@functools.cache
def _imported(file: Path, root: Path) -> tuple[Path, ...]:
    """Return the files below `root` that one file names in its import statements.

    `root` is what the namespace `seamark` stands for: a checkout, or the package as installed.
    """
    names = _names(compile(file.read_bytes(), str(file), "exec", dont_inherit=True))
    candidates = (
        root.joinpath(*name.split(".")[1:]) for name in names if name.startswith("seamark.")
    )
    files = (
        path for base in candidates for path in (base.with_suffix(".py"), base / "__init__.py")
    )
    return tuple(path for path in files if path.is_file() and path != file)


def _names(code: CodeType) -> Iterator[str]:
    """Yield the full names that may be modules: `from a import b` names a and a.b.

    From the compiled text, not its syntax tree: trees that two threads make at a time can fail in
    CPython before 3.11.5 (its issue 106905).
    """
    for kind, named in _FINDER.scan_opcodes(code):
        if kind == "absolute_import":
            members, module = named
            yield module
            yield from (f"{module}.{member}" for member in members or ())
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _names(constant)
