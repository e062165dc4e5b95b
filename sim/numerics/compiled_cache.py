"""Where Numba keeps compiled code: in a folder per state of the sources that it depends on.

Numba's own cache watches only the file of the compiled function. After a change in a file that it
imports, it would silently go on with the old code, and results would be of neither version. So the
folder of a function is named after its own file and all files of `sim` that this one imports,
directly or indirectly. A change compiles again what depends on it and nothing else. Folders that no
version on this machine has used for a while are removed.

Numba imports this module by name, from the variable that `numba_internals.configure_cache` sets.
"""

import functools
import hashlib
import importlib
import importlib.util
import os
import re
import shutil
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any, Self

from seamark.sim.numerics import late_bitcode
from seamark.sim.numerics.numba_internals import SOURCES, numba_folder

ROOT = SOURCES.parent
START_INTERNALS = ("numba.np.linalg:ensure_blas", "numba.np.arraymath:ensure_blas")
DAY_S = 86_400.0
UNUSED_MAX_S = 30 * DAY_S  # then compiled code is removed
_FOLDER = re.compile(r"numba-\w+-[0-9a-f]{16}")
_COMMENT = re.compile(r"#.*")
_IMPORT = re.compile(
    r"(?:^|[;:])[ \t]*"  # at the beginning of a line, or after another statement
    r"(?:from\s+(seamark(?:\.\w+)*)\s+import\s*(\([^)]*\)|[^\n;(]+)|import\s+([^\n;]+))",
    re.MULTILINE,
)


class SourceStampLocator:
    """Numba's cache locator for the functions of one file of `sim`.

    It has the methods of `numba.core.caching._CacheLocator` that Numba calls.
    """

    def __init__(self, file: Path, line: int) -> None:
        self._stamp = stamp(file, ROOT)
        self._line = line
        self._folder = numba_folder(os.environ) / f"numba-{file.stem}-{self._stamp[:16]}"

    @classmethod
    def from_function(cls, function: Callable[..., object], file: str) -> Self | None:
        """Return the locator of a compiled function; None for a function outside `sim`."""
        path = _own(file)
        if path is None:
            return None
        _prepare_numba()
        locator = cls(path, function.__code__.co_firstlineno)
        _use(locator._folder)
        return locator

    def ensure_cache_path(self) -> None:
        """Create the folder.

        Raises
        ------
        OSError
            It cannot be created or written to.
        """
        _check(self._folder)

    def get_cache_path(self) -> str:
        """Return the folder of the function's compiled code."""
        return str(self._folder)

    def get_source_stamp(self) -> str:
        """Return what must be unchanged for compiled code to be used."""
        return self._stamp

    def get_disambiguator(self) -> str:
        """Return what distinguishes functions of the same name in one file."""
        return str(self._line)


@functools.cache  # a file has up to twenty functions
def _own(file: str) -> Path | None:
    """Return the path of a file of `sim` without links; None for another."""
    path = Path(file).resolve()
    return path if path.is_relative_to(SOURCES) else None


@functools.cache  # before the first function is loaded
def _prepare_numba() -> None:
    late_bitcode.install()
    _load_numba_without_blas()


def _load_numba_without_blas() -> None:
    """Have Numba load its functions of arrays without SciPy's linear algebra.

    It only looks whether that is there: of the simulator, no function calls it, and one that did
    would load it then. That look took a tenth of the time until a process can simulate.
    """
    linalg: Any = importlib.import_module("numba.np.linalg")
    look, linalg.ensure_blas = linalg.ensure_blas, _require_scipy
    try:
        importlib.import_module("numba.np.arraymath")
    finally:
        linalg.ensure_blas = look


def _require_scipy() -> None:
    if importlib.util.find_spec("scipy") is None:
        raise ImportError("no SciPy")


def _check(folder: Path) -> None:
    """Create a folder; raise OSError if that fails, or it cannot be written to."""
    folder.mkdir(parents=True, exist_ok=True)
    tempfile.TemporaryFile(dir=folder).close()


@functools.cache
def _use(folder: Path) -> None:
    """Check a folder and note its use by its time, once a day; then look for unused ones."""
    known = folder.is_dir()
    _check(folder)
    with suppress(OSError):
        if not known or time.time() - folder.stat().st_mtime > DAY_S:
            os.utime(folder)
            prune(folder.parent)


@functools.cache
def prune(parent: Path) -> None:
    """Remove the folders that no version has used for long.

    Numba compiles what it finds missing: nothing breaks if another process still uses one.
    """
    oldest = time.time() - UNUSED_MAX_S
    for folder in parent.glob("numba-*"):
        with suppress(OSError):  # another process removes it as well
            if _FOLDER.fullmatch(folder.name) and folder.stat().st_mtime < oldest:
                removed = folder.with_name(f"{folder.name}.removed")  # at once as a whole
                folder.rename(removed)
                shutil.rmtree(removed)


@functools.cache
def stamp(file: Path, root: Path) -> str:
    """Return the SHA-256 over a source file and all files below `root` that it imports."""
    digest = hashlib.sha256()
    for parts, content in sorted(_parts_and_content(path, root) for path in _closure(file, root)):
        digest.update("/".join(parts).encode())
        digest.update(content)
    return digest.hexdigest()


@functools.cache  # a file is in the closures of dozens of others
def _parts_and_content(file: Path, root: Path) -> tuple[tuple[str, ...], bytes]:
    return file.relative_to(root).parts, file.read_bytes()


def _closure(file: Path, root: Path) -> set[Path]:
    """Return a file and all files that it imports, directly or indirectly."""
    closure: set[Path] = set()
    pending = [file]
    while pending:
        path = pending.pop()
        if path not in closure:
            closure.add(path)
            pending.extend(_imported(path, root))
    return closure


@functools.cache
def _imported(file: Path, root: Path) -> tuple[Path, ...]:
    """Return the files below `root` that appear in the import statements of one file."""
    names = imported_names(file.read_text("utf-8"))
    return tuple(path for name in names for path in _files(name, root) if path != file)


@functools.cache
def _files(name: str, root: Path) -> tuple[Path, ...]:
    """Return the files of a module, if it is one.

    `root` is the folder of the namespace `seamark`: a checkout, or the installed package.
    """
    base = root.joinpath(*name.split(".")[1:])
    return tuple(path for path in (base.with_suffix(".py"), base / "__init__.py") if path.is_file())


def imported_names(source: str) -> Iterator[str]:
    """Yield the full names below `seamark` that may be modules: `from a import b` names a and a.b.

    By a pattern, because compiling all sources to look for imports takes a tenth of a second. What
    looks like an import in a text costs nothing but a compilation too many.
    """
    for statement in _IMPORT.finditer(_COMMENT.sub("", source)):
        module, members, modules = statement.groups()
        if module:
            yield module
            yield from (f"{module}.{name}" for name in _first_words(members))
        else:
            yield from (name for name in _first_words(modules) if name.startswith("seamark."))


def _first_words(listed: str) -> Iterator[str]:
    """Yield the names of a list such as `a, b as c`, in parentheses or not."""
    return (words.split()[0] for words in listed.strip("()").split(",") if words.strip())
