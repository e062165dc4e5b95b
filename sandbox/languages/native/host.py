"""What the host has for C and C++: GCC with its headers for one box, nothing but libraries for the
other.

The compiler's messages, plug-ins and files belong to the box in which it runs; the box of the
finished program has no compiler.
"""

import os
from functools import cache
from pathlib import Path

from seamark.sandbox.languages.language import Bind, Runtime
from seamark.sandbox.languages.scripts import script_runtime
from seamark.sandbox.outcome import SandboxBroken

HERE = Path(__file__).parent
INSIDE = "/box/native"
TOOLS = ("as", "ld", "gcc")  # of any language: the runner is C
TREES = ("/usr/lib/gcc", "/usr/libexec/gcc", "/usr/include")  # cc1 and collect2; headers
ENVIRONMENT = {
    "PATH": "/usr/bin",
    "HOME": "/tmp",  # noqa: S108  (inside the box)
    "LC_ALL": "C",  # messages as everybody can search for them
    "TMPDIR": "/tmp",  # noqa: S108
    "MALLOC_ARENA_MAX": "2",
}
# No fused multiplication: the same arithmetic as Python's. Contraction is GCC's default for C++.
OPTIONS = (
    "-O2",
    "-ffp-contract=off",
    "-fmax-errors=20",
    "-fdiagnostics-color=never",
    f"-I{INSIDE}",
)


@cache
def compiling(compiler: str, *options: str, script: str = "native") -> Runtime:
    """Return what the box of the compiler needs; SandboxBroken if the compiler is missing.

    `script` calls it, with its command line as arguments.
    """
    tools = [_tool(name) for name in dict.fromkeys((*TOOLS, compiler))]
    trees = [Bind(Path(tree), tree) for tree in TREES if Path(tree).is_dir()]
    arguments = ("compile", f"/usr/bin/{compiler}", *OPTIONS, *options)
    binds = [*tools, *trees, *_ours("runner.c", "seamark.h")]
    return script_runtime(script, arguments=arguments, binds=binds, environment=ENVIRONMENT)


@cache
def running() -> Runtime:
    """Return what the box of a finished program needs."""
    return script_runtime("program", environment=ENVIRONMENT, images=True)


def _ours(*names: str) -> list[Bind]:
    return [Bind(HERE / name, f"{INSIDE}/{name}") for name in names]


def _tool(name: str) -> Bind:
    """Return a program of the system itself: a compiler elsewhere would need other files."""
    path = Path("/usr/bin", name)
    if not path.exists():
        raise SandboxBroken(f"{path} is not installed")
    return Bind(Path(os.path.realpath(path)), str(path))
