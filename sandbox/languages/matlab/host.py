"""What MATLAB programs need of the host: GNU Octave with its own functions, without packages."""

import os
from functools import cache
from pathlib import Path

from seamark.sandbox.languages.script_runtime import script_runtime
from seamark.sandbox.outcome import SandboxBroken
from seamark.sandbox.runtime import BindMount, Runtime, alternatives

INSIDE = Path(__file__).with_name("inside")
PROGRAM = Path("/usr/bin/octave-cli")
FUNCTIONS = Path("/usr/share/octave")
USR_LIB, MAGICK = Path("/usr/lib"), "libGraphicsMagick*.so.*"  # not beside the others
ENVIRONMENT = {
    "PATH": "/usr/bin",
    "HOME": "/tmp",  # noqa: S108  (inside the box)
    "LANG": "C.UTF-8",
    "OPENBLAS_NUM_THREADS": "1",  # with other numbers of threads the last bits differ
    "OPENBLAS_CORETYPE": "Haswell",  # as they do with other kernels
    "OMP_NUM_THREADS": "1",
    "MALLOC_ARENA_MAX": "2",
}


@cache
def octave_runtime() -> Runtime:
    """Return command, environment and files; SandboxBroken if Octave is missing."""
    if not PROGRAM.exists() or not FUNCTIONS.is_dir():
        raise SandboxBroken(f"{PROGRAM} is not installed")
    mounts = [
        BindMount(Path(os.path.realpath(PROGRAM)), str(PROGRAM)),
        BindMount(FUNCTIONS, str(FUNCTIONS)),
        BindMount(INSIDE / "runner.m", "/box/octave/runner.m"),
        *alternatives(),
        *(
            BindMount(Path(os.path.realpath(path)), str(path))
            for path in sorted(USR_LIB.glob(MAGICK))
        ),
    ]
    return script_runtime(INSIDE, "octave", mounts=mounts, environment=ENVIRONMENT, images=True)
