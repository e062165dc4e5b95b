"""What the simulator uses of Numba and llvmlite beyond their documented interfaces, and since when.

An update may change any of it without notice, so Numba is pinned to the minor version in
`pyproject.toml` (Numba itself pins llvmlite), a test checks every name below, and this module
decides what happens with another version:

Cache of compiled code (`compiled_cache.py`)
    The variable NUMBA_CACHE_LOCATOR_CLASSES and the methods that Numba calls of a locator: Numba's
    own locators watch only the file of a function, not the files that it imports, so after a change
    they go on using stale code. With another version of Numba its own locators are used, in a
    folder named after all sources of the simulator: every change compiles everything, but stale
    code is never used.
Loading without LLVM code (`late_bitcode.py`)
    How a library is made of what the cache holds, and that its machine code is an ELF file.
Calls without a search for types (`compilation.py`)
    `Dispatcher.compile` returns what can be called: the code for the given types.
Functions without reference counts (`uncounted.py`)
    The option `_nrt=False` of `njit`. A function that makes an array all the same does not compile.
Vectors of sixteen and of eight numbers (`simd.py`, `lanes.py`)
    Operators on types of our own, and parts of the code generator. Without vectors, sums would be
    added in another order and results would differ, so there is no fall-back: importing them
    fails with a sentence that says which version is needed.

Importing this module loads neither Numba nor NumPy.
"""

import hashlib
import importlib
import importlib.metadata
import sys
import warnings
from collections.abc import Iterable, Mapping, MutableMapping
from pathlib import Path

from seamark.sim.numerics.cache_folder import cache_folder

TESTED_NUMBA = "0.68"  # minor version; the same as in pyproject.toml
LOCATORS = (
    "seamark.sim.numerics.compiled_cache.SourceStampLocator,InTreeCacheLocator,UserWideCacheLocator"
)
SOURCES = Path(__file__).resolve().parents[1]  # the folder `sim`
_FALL_BACK = "numba-all-"

CACHE_INTERNALS = (
    "numba.core.config:CACHE_LOCATOR_CLASSES",  # the variable, as Numba has read it
    "numba.core.config:reload_config",
    "numba.core.caching:CacheImpl",  # calls the locators
)
CALL_INTERNALS = (
    "numba.core.dispatcher:Dispatcher.compile",  # returns the code's entry point
    "numba.core.options:DefaultOptions._nrt",  # whether references are counted
)
SIMD_INTERNALS = (
    "numba.core.cgutils:unpack_tuple",  # shape of an array
    "numba.core.cgutils:get_or_insert_function",  # declares an LLVM intrinsic
    "numba.core.cgutils:create_struct_proxy",  # members of a view
    "numba.core.imputils:lower_builtin",  # code of an operator
    "numba.core.imputils:lower_cast",  # a number as lanes
    "numba.core.typeconv:Conversion",
    "numba.core.typing.templates:AbstractTemplate",  # type of an item
    "numba.core.typing.templates:AttributeTemplate",  # type of a shape
    "numba.core.typing.templates:infer_getattr",
    "numba.core.typing.templates:ConcreteTemplate",  # type of an operator
    "numba.core.typing.templates:infer_global",
    "numba.core.typing.templates:signature",
    "numba.core.base:BaseContext.make_array",  # data pointer of an array
    "numba.core.base:BaseContext.cast",
    "numba.core.types:StarArgTuple",  # the lengths of an array on the stack
    "numba.np.arrayobj:populate_array",  # an array of memory that nobody counts
    "numba.core.base:BaseContext.get_dummy_value",
    "llvmlite.ir:Undefined",
    "llvmlite.ir.instructions:GEPInstr",  # its indices and type are replaced for a vector of them
)


def missing(internals: Iterable[str]) -> list[str]:
    """Return those internals, written module:attribute, that the installed versions lack."""
    return [internal for internal in internals if not _exists(internal)]


def _exists(internal: str) -> bool:
    module, _, attributes = internal.partition(":")
    try:
        value = importlib.import_module(module)
        for attribute in attributes.split("."):
            value = getattr(value, attribute)
    except (ImportError, AttributeError):
        return False
    return True


def require_simd() -> None:
    """Check that the installed Numba can compile the vectors of `simd.py` and `lanes.py`.

    Raises
    ------
    ImportError
        It cannot; the text says which version is needed.
    """
    if lacking := missing(SIMD_INTERNALS):
        raise ImportError(
            f"The simulator needs Numba {TESTED_NUMBA}: the installed version "
            f"{importlib.metadata.version('numba')} lacks {', '.join(lacking)}."
        )


def configure_cache(environ: MutableMapping[str, str], numba_version: str) -> None:
    """Set the variables by which Numba finds its cache; call it before anything is compiled."""
    if numba_version.startswith(f"{TESTED_NUMBA}."):
        environ.setdefault("NUMBA_CACHE_LOCATOR_CLASSES", LOCATORS)
        _read_again()
        return
    folder = _shared_folder(environ)
    environ["NUMBA_CACHE_DIR"] = str(folder)
    environ.pop("NUMBA_CACHE_LOCATOR_CLASSES", None)
    warnings.warn(
        f"Numba {numba_version} is not the tested version {TESTED_NUMBA}: after any change of the "
        f"simulator's sources all of it is compiled again. The cache is {folder}.",
        RuntimeWarning,
        stacklevel=2,
    )
    _read_again()


def _read_again() -> None:
    """Have Numba read its variables again, if it was imported before the simulator."""
    if (config := sys.modules.get("numba.core.config")) is not None:
        config.reload_config()


def numba_folder(environ: Mapping[str, str]) -> Path:
    """Return the folder of Numba's compiled code: as set, else as `cache_folder` finds it."""
    if configured := environ.get("NUMBA_CACHE_DIR"):
        return Path(configured)
    folder = cache_folder(SOURCES, environ)
    return folder / "__pycache__" if folder == SOURCES else folder


def _shared_folder(environ: Mapping[str, str]) -> Path:
    base = numba_folder(environ)
    if base.name.startswith(_FALL_BACK):  # set by the process that started this one
        base = base.parent
    return base / f"{_FALL_BACK}{_stamp_of_all_sources()[:16]}"


def _stamp_of_all_sources() -> str:
    digest = hashlib.sha256()
    for path in sorted(SOURCES.rglob("*.py")):
        digest.update(path.relative_to(SOURCES).as_posix().encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()
