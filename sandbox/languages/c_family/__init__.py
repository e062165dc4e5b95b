"""C and C++: for seamark.h, or C as Embedded Coder generates it; compiled by GCC in its own box."""

from pathlib import Path

from seamark.sandbox.languages.language import (
    ALL_ROLES,
    DETECTOR,
    TRACKER,
    Calls,
    Declarations,
    Language,
)
from seamark.sandbox.languages.sample import Sample, sample
from seamark.sandbox.limits import COMPILING
from seamark.sandbox.runtime import Runtime

HERE = Path(__file__).parent
HEADER = HERE / "seamark.h"
CODER = HERE / "conformance/embedded_coder"
CALLS = Calls("The program (constructors and seamark_init)", "seamark_reset", "seamark_step")
GCC_PACKAGES = ("gcc", "libc6-dev")  # gcc only recommends the headers
C_OPTIONS = (
    "-xc",  # whatever the suffix: `.C` would be C++
    "-std=c11",
    "-Werror=implicit-function-declaration",  # fabs without its header would return an int
)
CPP_OPTIONS = ("-xc++", "-std=c++17")


def compile_c() -> Runtime:
    """Return what the C compiler needs in its box."""
    from seamark.sandbox.languages.c_family.host import gcc_runtime  # noqa: PLC0415  (lazily)

    return gcc_runtime("gcc", *C_OPTIONS)


def compile_cpp() -> Runtime:
    """Return what the C++ compiler needs in its box."""
    from seamark.sandbox.languages.c_family import host  # noqa: PLC0415  (lazily)

    return host.gcc_runtime("g++", *CPP_OPTIONS, *host.cpp_libraries())


def run_binary() -> Runtime:
    """Return what a compiled program needs in its box."""
    from seamark.sandbox.languages.c_family.host import binary_runtime  # noqa: PLC0415  (lazily)

    return binary_runtime()


# What Embedded Coder generates is C too: an archive of it has rtwtypes.h beside the model.
C = Language(
    name="c",
    label="C",
    suffixes=(".c",),
    runtime=run_binary,
    compiler=compile_c,
    calls=CALLS,
    self_test=sample(HERE / "self_test.c"),
    starters=(
        sample(HERE / "starter/controller.c", HEADER),
        Sample(
            files={"controller.c": HERE / "starter/embedded_coder.c"},
            name="embedded-c",
            heading="Starter for Embedded Coder",
        ),
        Sample(
            files={"controller.c": HERE / "starter/arm_controller.c", HEADER.name: HEADER},
            moves_arm=True,
        ),
        Sample(
            files={"controller.c": HERE / "starter/arm_embedded_coder.c"},
            moves_arm=True,
            name="embedded-c",
            heading="Starter for Embedded Coder",
        ),
        sample(HERE / "starter/tracker.c", HEADER, role=TRACKER),
        sample(HERE / "starter/detector.c", HEADER, role=DETECTOR),
    ),
    conformance=(
        sample(HERE / "starter/controller.c"),
        Sample(files={path.name: path for path in sorted(CODER.iterdir())}, archive="pi.zip"),
        sample(HERE / "starter/tracker.c", role=TRACKER),
        sample(HERE / "starter/detector.c", role=DETECTOR),
    ),
    roles=ALL_ROLES,
    debian_packages=GCC_PACKAGES,
    archive_mains=("controller.c", "rtwtypes.h", "ert_main.c", "tracker.c", "detector.c"),
    syntax="c",
    declarations=Declarations.COMMENTS,
    in_the_box=(
        "The standard library and `-lm`, compiled with `-O2 -std=c11`. The compiler may use "
        f"{COMPILING.cpu_s:g} s of CPU time and {COMPILING.memory_mib} MiB."
    ),
)

CPP = Language(
    name="c++",
    label="C++",
    suffixes=(".cpp", ".cc"),
    runtime=run_binary,
    compiler=compile_cpp,
    calls=CALLS,
    self_test=sample(HERE / "self_test.cpp"),
    starters=(
        sample(HERE / "starter/controller.cpp", HEADER),
        Sample(
            files={"controller.cpp": HERE / "starter/arm_controller.cpp", HEADER.name: HEADER},
            moves_arm=True,
        ),
        sample(HERE / "starter/tracker.cpp", HEADER, role=TRACKER),
        sample(HERE / "starter/detector.cpp", HEADER, role=DETECTOR),
    ),
    conformance=(
        sample(HERE / "starter/controller.cpp"),
        sample(HERE / "starter/tracker.cpp", role=TRACKER),
        sample(HERE / "starter/detector.cpp", role=DETECTOR),
    ),
    roles=ALL_ROLES,
    debian_packages=("g++",),
    archive_mains=("controller.cpp", "controller.cc", "tracker.cpp", "detector.cpp"),
    syntax="cpp",
    declarations=Declarations.COMMENTS,
    in_the_box=(
        "Compiled with `-O2 -std=c++17`. Eigen (`#include <Eigen/Dense>`) and OpenCV "
        "(`#include <opencv2/imgproc.hpp>`) need no options if they are listed above; the OpenCV "
        "modules in brackets are linked. OpenCV in C++ is the one of the worker's system, and so "
        "older than that of Python."
    ),
)
