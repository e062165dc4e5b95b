"""What the host has for MATLAB programs: GNU Octave with its own functions, without packages."""

import os
from functools import cache
from pathlib import Path

from seamark.sandbox.languages.language import Bind, Runtime
from seamark.sandbox.languages.scripts import script_runtime
from seamark.sandbox.outcome import SandboxBroken

HERE = Path(__file__).parent
PROGRAM = Path("/usr/bin/octave-cli")
FUNCTIONS = Path("/usr/share/octave")
LIBRARIES = Path("/usr/lib/x86_64-linux-gnu")
OUTSIDE, PICTURES = Path("/usr/lib"), "libGraphicsMagick*.so.*"  # not where Debian has the others
ENVIRONMENT = {
    "PATH": "/usr/bin",
    "HOME": "/tmp",  # noqa: S108  (inside the box)
    "LANG": "C.UTF-8",
    "OPENBLAS_NUM_THREADS": "1",  # other numbers of threads give other last bits
    "OPENBLAS_CORETYPE": "Haswell",  # and so do other kernels
    "OMP_NUM_THREADS": "1",
    "MALLOC_ARENA_MAX": "2",
}


@cache
def running() -> Runtime:
    """Return command, environment and files; SandboxBroken if Octave is missing."""
    if not PROGRAM.exists() or not FUNCTIONS.is_dir():
        raise SandboxBroken(f"{PROGRAM} is not installed")
    binds = [
        Bind(Path(os.path.realpath(PROGRAM)), str(PROGRAM)),
        Bind(FUNCTIONS, str(FUNCTIONS)),
        Bind(HERE / "runner.m", "/box/octave/runner.m"),
        *alternatives(),
        *(Bind(Path(os.path.realpath(path)), str(path)) for path in sorted(OUTSIDE.glob(PICTURES))),
    ]
    return script_runtime("octave", binds=binds, environment=ENVIRONMENT, images=True)


def alternatives(libraries: Path = LIBRARIES) -> list[Bind]:
    """Return the libraries that Debian reaches over /etc/alternatives, which a box does not have.

    Which ones Octave needs depends on what the host has chosen: OpenBLAS comes with a third.
    """
    links = [link for link in sorted(libraries.glob("*.so.*")) if link.is_symlink()]
    targets = [(link, os.readlink(link)) for link in links if link.exists()]
    return [
        Bind(Path(os.path.realpath(link)), target)
        for link, target in targets
        if target.startswith("/etc/")
    ]
