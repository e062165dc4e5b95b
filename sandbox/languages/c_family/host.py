"""What C and C++ programs need of the host: GCC with its headers in the compiler's box, nothing but
libraries in the box of the compiled program. C++ has Eigen and OpenCV where they are installed.
"""

import hashlib
import os
import subprocess
from functools import cache
from pathlib import Path

from seamark.sandbox.languages.c_family.inside.compile_source import COMPILE_OURS
from seamark.sandbox.languages.script_runtime import script_runtime
from seamark.sandbox.outcome import SandboxBroken
from seamark.sandbox.runtime import LIBRARIES, BindMount, Runtime, alternatives

HERE = Path(__file__).parent
INSIDE = HERE / "inside"
HEADERS = "/box/native"
OURS = ("runner.c", "crash.c", "seamark.h")
KEPT = HERE / "__pycache__"  # beside the bytecode, which is kept for the same reason
TOOLS = ("as", "ld", "gcc")  # of any language: the runner is C
TREES = ("/usr/lib/gcc", "/usr/libexec/gcc", "/usr/include")  # cc1 and collect2; headers
# Optional, for C++. Modules that read and write files would load a hundred libraries of codecs.
OPENCV_HEADERS, EIGEN_HEADERS = Path("/usr/include/opencv4"), Path("/usr/include/eigen3")
OPENCV_MODULES = (
    *("core", "imgproc", "flann", "features2d", "calib3d", "video"),
    *("dnn", "ml", "objdetect", "photo", "tracking"),
)
ENVIRONMENT = {
    "PATH": "/usr/bin",
    "HOME": "/tmp",  # noqa: S108  (inside the box)
    "LC_ALL": "C",  # messages in English, for a search engine
    "TMPDIR": "/tmp",  # noqa: S108
    "OPENBLAS_NUM_THREADS": "1",  # with other numbers of threads the last bits differ
    "OPENBLAS_CORETYPE": "Haswell",  # as they do with other kernels
    "OMP_NUM_THREADS": "1",
    "MALLOC_ARENA_MAX": "2",
}
# No fused multiply-add: the same arithmetic as Python's. Contraction is GCC's default.
OPTIONS = (
    "-O2",
    "-g1",  # so that a crash can be reported with its line
    "-ffp-contract=off",
    "-fmax-errors=20",
    "-fdiagnostics-color=never",
    f"-I{HEADERS}",
)


@cache
def gcc_runtime(
    compiler: str, *options: str, inside: Path = INSIDE, script: str = "compile_source"
) -> Runtime:
    """Return what the compiler's box needs; SandboxBroken if the compiler is missing.

    The script gets the compiler's command line as arguments.
    """
    tools = [_tool(name) for name in dict.fromkeys((*TOOLS, compiler))]
    trees = [BindMount(Path(tree), tree) for tree in TREES if Path(tree).is_dir()]
    arguments = (f"/usr/bin/{compiler}", *OPTIONS, *options)
    ours = [BindMount(HERE / name, f"{HEADERS}/{name}") for name in OURS]
    ours += [BindMount(path, f"{HEADERS}/{name}") for name, path in our_objects().items()]
    return script_runtime(
        inside,
        script,
        uses=[] if inside == INSIDE else [INSIDE],
        arguments=arguments,
        mounts=[*tools, *trees, *ours, *alternatives()],
        environment=ENVIRONMENT,
    )


@cache
def our_objects(kept_in: Path = KEPT) -> dict[str, Path]:
    """Return name -> object file of our part of each program, compiled once if it can be kept.

    Otherwise each box compiles it, which takes longer than most programs.
    """
    gcc = Path(os.path.realpath(COMPILE_OURS[0]))
    states = [file.stat() for file in (gcc, *(HERE / name for name in OURS))]
    text = f"{COMPILE_OURS} {[(state.st_mtime_ns, state.st_size) for state in states]}"
    stamp = hashlib.sha256(text.encode()).hexdigest()[:16]
    objects = {}
    for source in (name for name in OURS if name.endswith(".c")):
        name = f"{source.removesuffix('.c')}.o"
        objects[name] = kept_in / f"{stamp}-{name}"
        if os.access(objects[name], os.R_OK):
            continue
        partial = kept_in / f"{stamp}-{os.getpid()}-{name}"  # several processes may start at once
        command = [*COMPILE_OURS, "-c", source, "-o", str(partial)]
        try:
            kept_in.mkdir(exist_ok=True)
            subprocess.run(command, cwd=HERE, env=ENVIRONMENT, check=True, capture_output=True)
            partial.rename(objects[name])
        except (OSError, subprocess.CalledProcessError):  # no permission, for instance
            return {}
    return objects


@cache
def binary_runtime() -> Runtime:
    """Return what the box of a compiled program needs."""
    return script_runtime(
        INSIDE, "program", mounts=alternatives(), environment=ENVIRONMENT, images=True
    )


def cpp_libraries() -> tuple[str, ...]:
    """Return the options for the optional libraries that this host has."""
    headers = [folder for folder in (OPENCV_HEADERS, EIGEN_HEADERS) if folder.is_dir()]
    modules = [name for name in OPENCV_MODULES if (LIBRARIES / f"libopencv_{name}.so").exists()]
    return (*(f"-isystem{folder}" for folder in headers), *(f"-lopencv_{name}" for name in modules))


def _tool(name: str) -> BindMount:
    """Return a program of the system itself: a compiler elsewhere would need other files."""
    path = Path("/usr/bin", name)
    if not path.exists():
        raise SandboxBroken(f"{path} is not installed")
    return BindMount(Path(os.path.realpath(path)), str(path))
