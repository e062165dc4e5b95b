"""What Python programs need of the host: interpreter, standard library, NumPy and SciPy.

Mounted one by one, never as a whole tree: a box sees no other package, no program and no setting of
the host.
"""

import compileall
import importlib.util
import os
import re
from functools import cache
from pathlib import Path

from seamark.sandbox.languages.script_runtime import (
    inside_mounts,
    interpreter_files,
    module_name,
)
from seamark.sandbox.outcome import SandboxBroken
from seamark.sandbox.runtime import BindMount, Runtime

PACKAGES = ("numpy", "scipy")
PACKAGES_FOLDER = "/box/packages"
INSIDE = Path(__file__).with_name("inside")
TESTS = re.compile(r"[/\\]tests[/\\]")  # the packages' own tests: half of their files

ENVIRONMENT = {
    "PATH": "/usr/bin:/bin",
    "HOME": "/tmp",  # noqa: S108  (inside the box)
    "LANG": "C.UTF-8",
    "PYTHONHASHSEED": "0",  # `-I` would ignore it: the order of sets would change between runs
    "PYTHONPATH": PACKAGES_FOLDER,
    "OPENBLAS_NUM_THREADS": "1",  # with other numbers of threads the last bits differ
    "OPENBLAS_CORETYPE": "Haswell",  # as they do with other kernels
    "OMP_NUM_THREADS": "1",
    "MALLOC_ARENA_MAX": "2",
}


@cache
def python_runtime() -> Runtime:
    """Return command, environment and files; SandboxBroken if NumPy or SciPy is missing."""
    command, files = interpreter_files()
    mounts = (*files, *_package_mounts(), *inside_mounts(PACKAGES_FOLDER, INSIDE))
    # Garbage collection finds nothing while NumPy is imported, and would take a tenth of the time.
    script = f"import gc; gc.disable(); from {module_name(INSIDE, 'runner')} import main; main()"
    return Runtime((*command, "-c", script), ENVIRONMENT, mounts, images=True)


def _package_mounts() -> list[BindMount]:
    mounts = []
    for name in PACKAGES:
        folder = package_folder(name)
        for source in (folder, folder.with_name(f"{name}.libs")):
            if source.is_dir():
                mounts.append(BindMount(source, f"{PACKAGES_FOLDER}/{source.name}"))
    return mounts


def package_folder(name: str) -> Path:
    """Return the folder of a package without importing it."""
    found = importlib.util.find_spec(name)
    if found is None or found.origin is None:
        raise SandboxBroken(f"{name} is not installed in the environment of this service")
    return Path(found.origin).parent


def compile_packages() -> bool:
    """Compile NumPy and SciPy to bytecode once; False if this is needed but not permitted.

    Without it each start takes 100 ms longer: a box cannot keep compiled files.
    """
    for folder in map(package_folder, PACKAGES):
        if all(source.with_name("__pycache__").is_dir() for source in folder.glob("*/__init__.py")):
            continue
        if not os.access(folder, os.W_OK):
            return False
        compileall.compile_dir(folder, quiet=2, rx=TESTS, workers=1)
    return True
