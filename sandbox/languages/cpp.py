"""C++: as C, with another compiler and standard."""

from seamark.sandbox.languages.c import running
from seamark.sandbox.languages.language import Language, Runtime
from seamark.sandbox.languages.native import CALLS, ROLES, SELF_TEST


def compiling() -> Runtime:
    """Return what the compiler needs in its box."""
    from seamark.sandbox.languages.native.host import compiling  # noqa: PLC0415  (looks at the host)

    return compiling("g++", "-xc++", "-std=c++17")


SOURCE = "#include <vector>\n" + SELF_TEST  # the library of C++ must be there too
CPP = Language(
    *("c++", "C++", (".cpp", ".cc"), running, SOURCE),
    compiler=compiling,
    calls=CALLS,
    roles=ROLES,
    packages=("g++",),
    mains=("controller.cpp", "controller.cc"),
)
