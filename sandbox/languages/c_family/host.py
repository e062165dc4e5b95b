"""What C and C++ programs need of the host: GCC with its headers in the compiler's box, nothing but
libraries in the box of the compiled program.
"""

import os
from functools import cache
from pathlib import Path

from seamark.sandbox.languages.script_runtime import script_runtime
from seamark.sandbox.outcome import SandboxBroken
from seamark.sandbox.runtime import BindMount, Runtime

HERE = Path(__file__).parent
INSIDE = HERE / "inside"
HEADERS = "/box/native"
TOOLS = ("as", "ld", "gcc")  # of any language: the runner is C
TREES = ("/usr/lib/gcc", "/usr/libexec/gcc", "/usr/include")  # cc1 and collect2; headers
ENVIRONMENT = {
    "PATH": "/usr/bin",
    "HOME": "/tmp",  # noqa: S108  (inside the box)
    "LC_ALL": "C",  # messages in English, for a search engine
    "TMPDIR": "/tmp",  # noqa: S108
    "MALLOC_ARENA_MAX": "2",
}
# No fused multiply-add: the same arithmetic as Python's. Contraction is GCC's default.
OPTIONS = (
    "-O2",
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
    ours = [BindMount(HERE / name, f"{HEADERS}/{name}") for name in ("runner.c", "seamark.h")]
    return script_runtime(
        inside,
        script,
        uses=[] if inside == INSIDE else [INSIDE],
        arguments=arguments,
        mounts=[*tools, *trees, *ours],
        environment=ENVIRONMENT,
    )


@cache
def binary_runtime() -> Runtime:
    """Return what the box of a compiled program needs."""
    return script_runtime(INSIDE, "program", environment=ENVIRONMENT, images=True)


def _tool(name: str) -> BindMount:
    """Return a program of the system itself: a compiler elsewhere would need other files."""
    path = Path("/usr/bin", name)
    if not path.exists():
        raise SandboxBroken(f"{path} is not installed")
    return BindMount(Path(os.path.realpath(path)), str(path))
