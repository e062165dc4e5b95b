"""What Python programs need of the host: interpreter, standard library, some packages.

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

PACKAGES = {  # package -> the folder beside it with its native libraries
    "numpy": "numpy.libs",
    "scipy": "scipy.libs",
    "cv2": "opencv_contrib_python_headless.libs",
    "onnxruntime": "",
}
OPTIONAL = ("onnxruntime",)  # workers without the extra "box" do without it
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
    "OPENCV_FOR_THREADS_NUM": "1",
    "ORT_DISABLE_TELEMETRY": "1",  # ONNX Runtime's, on by default, would start a thread
    "MALLOC_ARENA_MAX": "2",
}


@cache
def python_runtime() -> Runtime:
    """Return command, environment and files; SandboxBroken if a required package is missing."""
    command, files = interpreter_files()
    mounts = (*files, *_package_mounts(), *inside_mounts(PACKAGES_FOLDER, INSIDE))
    # Garbage collection finds nothing while NumPy is imported, and would take a tenth of the time.
    script = f"import gc; gc.disable(); from {module_name(INSIDE, 'runner')} import main; main()"
    return Runtime((*command, "-c", script), ENVIRONMENT, mounts, images=True)


def _package_mounts() -> list[BindMount]:
    mounts = []
    for name in installed_packages():
        folder = package_folder(name)
        libraries = [folder.with_name(PACKAGES[name])] if PACKAGES[name] else []
        for source in (folder, *libraries):
            if source.is_dir():
                mounts.append(BindMount(source, f"{PACKAGES_FOLDER}/{source.name}"))
    return mounts


def installed_packages() -> list[str]:
    """Return the packages that boxes can have here: all except missing optional ones."""
    return [name for name in PACKAGES if name not in OPTIONAL or importlib.util.find_spec(name)]


def package_folder(name: str) -> Path:
    """Return the folder of a package without importing it."""
    spec = importlib.util.find_spec(name)
    if spec is None or spec.origin is None:
        raise SandboxBroken(f"{name} is not installed in the environment of this service")
    return Path(spec.origin).parent


def compile_packages() -> bool:
    """Compile the packages to bytecode once; False if this is needed but not permitted.

    Without it each start takes 100 ms longer: a box cannot keep compiled files.
    """
    for folder in map(package_folder, installed_packages()):
        if all(source.with_name("__pycache__").is_dir() for source in folder.glob("*/__init__.py")):
            continue
        if not os.access(folder, os.W_OK):
            return False
        compileall.compile_dir(folder, quiet=2, rx=TESTS, workers=1)
    return True
