"""What the host has for Python programs: interpreter, standard library, NumPy and SciPy.

Bound one by one, never a whole tree: a box sees no other package, no program and no setting of
the host.
"""

import compileall
import importlib.util
import os
import re
import sys
import sysconfig
from dataclasses import replace
from functools import cache
from pathlib import Path

from seamark.sandbox.isolation.readable_copies import shelved
from seamark.sandbox.languages.language import Bind, Runtime
from seamark.sandbox.outcome import SandboxBroken

PACKAGES = ("numpy", "scipy")
INSIDE = "/box"
RUNNER = "seamark_runner"  # the package's name inside: an uploaded file is hardly called so
TESTS = re.compile(r"[/\\]tests[/\\]")  # the packages' own tests: half of their files

ENVIRONMENT = {
    "PATH": "/usr/bin:/bin",
    "HOME": "/tmp",  # noqa: S108  (inside the box)
    "LANG": "C.UTF-8",
    "PYTHONHASHSEED": "0",  # `-I` would ignore it: the order of sets would change between runs
    "PYTHONPATH": f"{INSIDE}/packages",
    "OPENBLAS_NUM_THREADS": "1",  # other numbers of threads give other last bits
    "OPENBLAS_CORETYPE": "Haswell",  # and so do other kernels
    "OMP_NUM_THREADS": "1",
    "MALLOC_ARENA_MAX": "2",
}


@cache
def python_runtime() -> Runtime:
    """Return command, environment and files; SandboxBroken if NumPy or SciPy is missing."""
    command, files = interpreter_files()
    inside = Path(__file__).with_name("python_inside")
    compileall.compile_dir(inside, quiet=2, workers=1)  # some ms of each start, where we may
    runner = Bind(inside, f"{INSIDE}/packages/{RUNNER}")
    binds = [*files, *_packages(), runner]
    reached = tuple(replace(bind, source=shelved(bind.source)) for bind in binds)
    # While NumPy is imported there is nothing to collect, and looking for it takes a tenth of it.
    start = ("-c", f"import gc; gc.disable(); from {RUNNER}.runner import main; main()")
    return Runtime((*command, *start), ENVIRONMENT, reached, images=True)


def interpreter_files() -> tuple[tuple[str, ...], list[Bind]]:
    """Return the command of the interpreter, and the files that it needs without any package."""
    interpreter = Path(os.path.realpath(sys.executable))
    command = (str(interpreter), "-s", "-P", "-B", "-S", "-X", "utf8")
    return command, [Bind(interpreter, str(interpreter)), *_standard_library()]


def _standard_library() -> list[Bind]:
    # Of the interpreter itself: in a virtual environment "platstdlib" is the environment's own
    # folder, with all its packages.
    base = {"base": sys.base_prefix, "platbase": sys.base_exec_prefix}
    folders = {sysconfig.get_path(name, vars=base) for name in ("stdlib", "platstdlib")}
    binds = [Bind(Path(folder), folder) for folder in sorted(folders)]
    if sys.base_prefix != "/usr":  # an interpreter of its own brings its library along
        shared = sorted(Path(sys.base_prefix, "lib").glob("libpython*.so*"))
        binds += [Bind(Path(os.path.realpath(path)), str(path)) for path in shared]
    return binds


def _packages() -> list[Bind]:
    binds = []
    for name in PACKAGES:
        folder = package_folder(name)
        for source in (folder, folder.with_name(f"{name}.libs")):
            if source.is_dir():
                binds.append(Bind(source, f"{INSIDE}/packages/{source.name}"))
    return binds


def package_folder(name: str) -> Path:
    """Return the folder of a package without importing it."""
    found = importlib.util.find_spec(name)
    if found is None or found.origin is None:
        raise SandboxBroken(f"{name} is not installed beside this service")
    return Path(found.origin).parent


def compile_packages() -> bool:
    """Compile NumPy and SciPy to bytecode once; False if they are not and we may not.

    Without it each start takes 100 ms longer: a box can keep no compiled file.
    """
    for folder in map(package_folder, PACKAGES):
        if all(source.with_name("__pycache__").is_dir() for source in folder.glob("*/__init__.py")):
            continue
        if not os.access(folder, os.W_OK):
            return False
        compileall.compile_dir(folder, quiet=2, rx=TESTS, workers=1)
    return True
