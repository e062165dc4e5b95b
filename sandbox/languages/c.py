"""C: for seamark.h, or as Embedded Coder generates it; compiled by GCC in a box of its own."""

from seamark.sandbox.languages.language import Language, Runtime
from seamark.sandbox.languages.native import CALLS, GCC, ROLES, SELF_TEST

OPTIONS = (
    "-xc",  # whatever the suffix: `.C` would be C++
    "-std=c11",
    "-Werror=implicit-function-declaration",  # fabs without its header would return an int
)


def compiling() -> Runtime:
    """Return what the compiler needs in its box."""
    from seamark.sandbox.languages.native.host import compiling  # noqa: PLC0415  (looks at the host)

    return compiling("gcc", *OPTIONS)


def running() -> Runtime:
    """Return what the compiled program needs in its box."""
    from seamark.sandbox.languages.native.host import running  # noqa: PLC0415

    return running()


# What Embedded Coder generates is C too: an archive of it has rtwtypes.h beside the model.
C = Language(
    *("c", "C", (".c",), running, SELF_TEST),
    compiler=compiling,
    calls=CALLS,
    roles=ROLES,
    packages=GCC,
    mains=("controller.c", "rtwtypes.h", "ert_main.c"),
)
