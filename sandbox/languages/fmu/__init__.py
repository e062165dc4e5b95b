"""FMU: a model for co-simulation by FMI 2.0 or 3.0, as Simulink, OpenModelica and others export it.

Never opened outside a box. One that brings C sources instead of a binary for this platform is
compiled first, in a box of its own.
"""

from pathlib import Path

from seamark.sandbox.languages.c_family import GCC_PACKAGES
from seamark.sandbox.languages.language import Calls, Declarations, Language
from seamark.sandbox.languages.sample import Sample
from seamark.sandbox.runtime import Runtime

HERE = Path(__file__).parent
GCC_OPTIONS = (
    "-shared",
    "-fPIC",
    "-Isources",
    "-DFMI2_FUNCTION_PREFIX=",
    "-DFMI3_FUNCTION_PREFIX=",
)
ENVIRONMENT = {
    "PATH": "/usr/bin:/bin",
    "HOME": "/tmp",  # noqa: S108  (inside the box)
    "LANG": "C.UTF-8",
    "MALLOC_ARENA_MAX": "2",
}


def compiler() -> Runtime:
    """Return what the box needs that reads an FMU, and compiles it if necessary."""
    from seamark.sandbox.languages.c_family.host import gcc_runtime  # noqa: PLC0415  (lazily)

    return gcc_runtime("gcc", *GCC_OPTIONS, inside=HERE / "inside", script="compile")


def runtime() -> Runtime:
    """Return what a box needs to load an FMU."""
    from seamark.sandbox.languages.script_runtime import script_runtime  # noqa: PLC0415  (lazily)

    return script_runtime(HERE / "inside", "runner", environment=ENVIRONMENT)


def _fmu(name: str, folder: str, description: str, source: str, extra: str = "") -> Sample:
    """Return an FMU of C sources, with a mapping of its names if there is one."""
    files = {
        "modelDescription.xml": HERE / folder / description,
        f"sources/{source}": HERE / folder / source,
    }
    if extra:
        files["extra/seamark.json"] = HERE / folder / extra
    return Sample(files=files, archive=name)


def _starter(prefix: str = "") -> Sample:
    """Return the starter; the one that moves an arm has a prefix."""
    return Sample(
        files={
            "modelDescription.xml": HERE / f"starter/{prefix}modelDescription.xml",
            "sources/controller.c": HERE / f"starter/{prefix}controller.c",
            "sources/fmi2.h": HERE / "starter/fmi2.h",
        },
        archive="controller.fmu",
        moves_arm=bool(prefix),
        heading="Model description of the FMU starter",
    )


FMU = Language(
    name="fmu",
    label="FMU (FMI 2.0 and 3.0, for co-simulation)",
    suffixes=(".fmu",),
    runtime=runtime,
    compiler=compiler,
    calls=Calls(
        "The FMU (loading and instantiation)", "the FMU's initialization", "the FMU's step"
    ),
    self_test=_fmu("self_test.fmu", "self_test", "modelDescription.xml", "model.c"),
    starters=(_starter(), _starter("arm_")),
    conformance=(
        _fmu("fmi2.fmu", "conformance", "fmi2.xml", "fmi2.c", "fmi2.json"),
        _fmu("fmi3.fmu", "conformance", "fmi3.xml", "fmi3.c"),
    ),
    is_archive=True,
    debian_packages=GCC_PACKAGES,
    noun="an FMU",
    syntax="xml",
    declarations=Declarations.MODEL,
    sets_by_name=True,
    in_the_box="An FMU brings its own code. C sources in it are compiled with the GCC of C.",
)
