"""Runtimes whose first process is one of our Python scripts, beside a user's program.

A language's scripts are in its folder `inside`; those that several languages share are in
`languages/inside`. A box sees them as the package `seamark_inside`, laid out as here, so that
relative imports are the same on both ends. Nothing in them is trusted by the simulator.
"""

import compileall
import os
import sys
import sysconfig
from collections.abc import Iterable, Mapping
from pathlib import Path

from seamark.sandbox.runtime import BindMount, Runtime

SHARED = Path(__file__).with_name("inside")
PACKAGES = "/box/python"
PACKAGE = "seamark_inside"  # an upload is unlikely to have this name
HOMES = ("/home/", "/root/")
PYTHON_INSIDE = Path("/box/interpreter")  # of an interpreter below a home


def script_runtime(
    inside: Path,
    script: str,
    *,
    uses: Iterable[Path] = (),
    arguments: Iterable[str] = (),
    mounts: Iterable[BindMount] = (),
    environment: Mapping[str, str],
    images: bool = False,
) -> Runtime:
    """Return what a box needs to run `main` of a script.

    Parameters
    ----------
    inside
        The folder `inside` of the language, with the module `script`.
    uses
        The folders `inside` of other languages that the script imports.
    arguments
        Go before `--`, the descriptor's number and the limits of processes and memory [MiB].
    """
    command, files = interpreter_files()
    packages = inside_mounts(PACKAGES, inside, *uses)
    start = ("-c", f"from {module_name(inside, script)} import main; main()")  # -m imports more
    return Runtime(
        (*command, *start, *arguments, "--"),
        {**environment, "PYTHONPATH": PACKAGES},
        (*files, *packages, *mounts),
        images=images,
    )


def module_name(inside: Path, script: str) -> str:
    """Return the dotted name of a script in the box."""
    return f"{PACKAGE}.{inside.parent.name}.{inside.name}.{script}"


def inside_mounts(packages: str, *folders: Path) -> list[BindMount]:
    """Return the mounts of the shared scripts and of some languages' own."""
    mounts = [BindMount(SHARED, f"{packages}/{PACKAGE}/{SHARED.name}")]
    for folder in folders:
        target = f"{packages}/{PACKAGE}/{folder.parent.name}/{folder.name}"
        mounts.append(BindMount(folder, target))
    for mount in mounts:
        compileall.compile_dir(mount.source, quiet=2, workers=1)  # saves 20 ms of each start
    return mounts


def interpreter_files() -> tuple[tuple[str, ...], list[BindMount]]:
    """Return the command of this service's interpreter, and its files without any package."""
    interpreter = Path(os.path.realpath(sys.executable))
    command = (_target(interpreter), "-s", "-P", "-B", "-S", "-X", "utf8")
    return command, [BindMount(interpreter, command[0]), *_standard_library()]


def _target(file: Path) -> str:
    """Return the path in the box of a file of the interpreter: no home is to be seen there."""
    prefix = os.path.realpath(sys.base_prefix)
    if prefix.startswith(HOMES) and file.is_relative_to(prefix):  # of pyenv or uv, for instance
        return str(PYTHON_INSIDE / file.relative_to(prefix))
    return str(file)


def _standard_library() -> list[BindMount]:
    # The interpreter's own: in a virtual environment "platstdlib" would be the environment's
    # folder, with all of its packages.
    base = {"installed_base": sys.base_prefix, "platbase": sys.base_exec_prefix}
    paths = [sysconfig.get_path(name, vars=base) for name in ("stdlib", "platstdlib")]
    folders = {Path(os.path.realpath(path)) for path in paths}
    mounts = [BindMount(folder, _target(folder)) for folder in sorted(folders)]
    if sys.base_prefix != "/usr":  # an interpreter outside /usr may bring its own library
        libraries = Path(os.path.realpath(sys.base_prefix), "lib")
        shared = sorted(libraries.glob("libpython*.so*"))
        mounts += [BindMount(Path(os.path.realpath(path)), _target(path)) for path in shared]
    return mounts
