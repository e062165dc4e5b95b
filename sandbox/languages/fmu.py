"""FMU: a model for co-simulation by FMI 2.0 or 3.0, as Simulink, OpenModelica and others export it.

Never opened outside a box. One that brings C sources instead of a program for this platform is
compiled in a box of its own first.
"""

import io
import zipfile

from seamark.sandbox.languages.language import Calls, Language, Runtime
from seamark.sandbox.languages.native import GCC

CALLS = Calls("The FMU (loading and instantiation)", "the FMU's initialization", "the FMU's step")
LINKED = ("-shared", "-fPIC", "-Isources", "-DFMI2_FUNCTION_PREFIX=", "-DFMI3_FUNCTION_PREFIX=")
SETTINGS = {
    "PATH": "/usr/bin:/bin",
    "HOME": "/tmp",  # noqa: S108  (inside the box)
    "LANG": "C.UTF-8",
    "MALLOC_ARENA_MAX": "2",
}

DESCRIPTION = """\
<fmiModelDescription fmiVersion="2.0" modelName="self-test" guid="1">
  <CoSimulation modelIdentifier="self_test"/>
  <ModelVariables>
    <ScalarVariable name="error_x" valueReference="0" causality="input"><Real/></ScalarVariable>
    <ScalarVariable name="error_y" valueReference="1" causality="input"><Real/></ScalarVariable>
    <ScalarVariable name="error_z" valueReference="2" causality="input"><Real/></ScalarVariable>
    <ScalarVariable name="surge" valueReference="3" causality="output"><Real/></ScalarVariable>
    <ScalarVariable name="sway" valueReference="4" causality="output"><Real/></ScalarVariable>
    <ScalarVariable name="heave" valueReference="5" causality="output"><Real/></ScalarVariable>
  </ModelVariables>
</fmiModelDescription>
"""
SOURCE = """\
#include <stddef.h>
static double values[6];
void *fmi2Instantiate(const char *name, int type, const char *guid) { return values; }
int fmi2SetupExperiment(void *model) { return 0; }
int fmi2EnterInitializationMode(void *model) { return 0; }
int fmi2ExitInitializationMode(void *model) { return 0; }
int fmi2SetReal(void *model, const unsigned *which, size_t count, const double *to) {
    for (size_t i = 0; i < count; i++) values[which[i]] = to[i];
    return 0;
}
int fmi2GetReal(void *model, const unsigned *which, size_t count, double *to) {
    for (size_t i = 0; i < count; i++) to[i] = values[which[i]];
    return 0;
}
int fmi2DoStep(void *model, double t, double dt, int final) {
    for (int i = 0; i < 3; i++) values[3 + i] = 0.5 * values[i];
    return 0;
}
"""


def self_test() -> bytes:
    """Return an FMU of sources that answers half the error."""
    whole = io.BytesIO()
    with zipfile.ZipFile(whole, "w") as archive:
        archive.writestr("modelDescription.xml", DESCRIPTION)
        archive.writestr("sources/model.c", SOURCE)
    return whole.getvalue()


def compiling() -> Runtime:
    """Return what the box needs that reads an FMU and compiles it if it must."""
    from seamark.sandbox.languages.native.host import compiling  # noqa: PLC0415  (looks at the host)

    return compiling("gcc", *LINKED, script="fmu_compile")


def running() -> Runtime:
    """Return what a box needs to load an FMU."""
    from seamark.sandbox.languages.scripts import script_runtime  # noqa: PLC0415

    return script_runtime("fmu", environment=SETTINGS)


FMU = Language(
    *("fmu", "FMU (FMI 2.0 and 3.0, for co-simulation)", (".fmu",), running, self_test),
    compiler=compiling,
    calls=CALLS,
    packed=True,
    packages=GCC,
)
