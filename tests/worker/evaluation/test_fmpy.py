"""The FMUs of the tests and of `seamark init` beside FMPy: valid, and the same outputs.

So what runs in a box is what other tools take for an FMU, not a dialect of ours.
"""

import io
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu

from seamark.sandbox.box import Box
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.languages.fmu import FMU
from seamark.sandbox.limits import Limits
from tests.sandbox import host_compiler
from tests.services.languages import skip_without

DT_S = 0.05
STEPS = 20
ERROR = (0.3, -0.2, 0.1)  # [m] constant: FMPy interpolates its inputs
CONFIG = {
    **{"kp": 0.7, "ki": 0.3, "control_heave": True},
    "reference_limit_m_s": 0.3,  # the first output meets it
}
LAYOUT = {
    "observation": [["error", 3], ["target_visible", 0]],
    "booleans": ["target_visible"],
    "command": ["surge", "sway", "heave", "yaw_rate"],
}
# What the models call the numbers of the configuration.
PARAMETERS = {
    "fmi2": {"limit": 0.3, "heave_too": True, "kp": 0.7, "ki": 0.3},
    "fmi3": CONFIG,
    "template": CONFIG,
}
INPUTS = {
    "fmi2": ("error[1]", "error[2]", "error_z"),
    "template": ("error_x", "error_y", "error_z"),
}


def fmu(name: str, folder: Path) -> bytes:
    """Return one of our FMUs with a program for this machine."""
    if name != "template":
        return host_compiler.fmu(name, folder)
    files = FMU.starters[0].contents()
    for source in ("controller.c", "fmi2.h"):
        (folder / source).write_bytes(files[f"sources/{source}"])
    target = folder / "controller.so"
    library = host_compiler.compiled_on_host([folder / "controller.c"], target, "-shared", "-fPIC")
    with zipfile.ZipFile(io.BytesIO(files["controller.fmu"])) as archive:
        members = {member: archive.read(member) for member in archive.namelist()}
    return host_compiler.zipped(members | {"binaries/linux64/controller.so": library})


def boxed(program: bytes, isolation: IsolationLevel) -> list[tuple[float, ...]]:
    """Return the commands of an FMU in a box."""
    with Box("fmu", limits=Limits(), isolation=isolation) as box:
        box.load(program, "mine.fmu", CONFIG, LAYOUT)
        box.reset({"t": 0.0, "dt": DT_S})
        commands = [tuple(box.step([*ERROR, 1.0])) for _ in range(STEPS)]
        box.finish()
    return commands


def inputs(name: str) -> np.ndarray:
    """Return what FMPy gives to the model at all times."""
    if name == "fmi3":
        fields = [("time", "f8"), ("error", "f8", (3,)), ("target_visible", "?")]
        rows = [(t, ERROR, True) for t in (0.0, 10.0)]
    else:
        fields = [(word, "f8") for word in ("time", *INPUTS[name])] + [("target_visible", "?")]
        rows = [(t, *ERROR, True) for t in (0.0, 10.0)]
    return np.array(rows, dtype=fields)


@pytest.mark.parametrize("name", ["fmi2", "fmi3", "template"])
def test_fmpy_finds_no_problem_in_it(name, tmp_path) -> None:
    path = tmp_path / "mine.fmu"
    path.write_bytes(fmu(name, tmp_path))

    assert validate_fmu(str(path)) == []


@pytest.mark.host
@pytest.mark.parametrize("name", ["fmi2", "fmi3", "template"])
def test_fmpy_gets_the_outputs_that_a_box_gets(name, tmp_path, isolation) -> None:
    skip_without("fmu", isolation)
    program = fmu(name, tmp_path)
    path = tmp_path / "mine.fmu"
    path.write_bytes(program)
    outputs = ["command"] if name == "fmi3" else ["surge", "sway", "heave"]

    result = fmpy.simulate_fmu(
        str(path),
        stop_time=STEPS * DT_S,
        step_size=DT_S,
        output_interval=DT_S,
        start_values=PARAMETERS[name],
        input=inputs(name),
        output=outputs,
        fmi_type="CoSimulation",
    )

    theirs = np.column_stack([result[output] for output in outputs])[1:, :3]
    ours = np.array(boxed(program, isolation))[:, :3]
    assert theirs.shape == ours.shape
    assert np.allclose(theirs, ours, rtol=1e-12, atol=0.0)  # FMPy's steps differ in the last bits
    assert len(np.unique(ours[:, 1])) == STEPS  # the integral grows
