"""The programs to start from that move an arm, and its kinematics in a program's archive."""

import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from seamark.programs.arm_helpers import helper
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.languages import starters
from seamark.sim import registry
from seamark.sim.control.manipulation.arm_reading import data_of, mount_of
from seamark.sim.control.manipulation.kinematics import ArmKinematics
from seamark.sim.recording.telemetry import ARM_INDEX
from seamark.sim.vehicles import load
from seamark.sim.vehicles.linkage_reading import load_linkage
from seamark.worker.evaluation.local import Callbacks
from seamark.worker.ipc.outcomes import RunOutcome
from tests.sandbox.host_compiler import zipped
from tests.worker.evaluation.languages import built, evaluated

pytestmark = pytest.mark.host

SHORT = {"levels": [0.1], "level_duration_s": 4.0, "tracker": "truth"}
POSTURE_RAD = [0.0, 0.45, 0.6, 0.0, 0.6]  # of the starters
MOTORS = slice(ARM_INDEX["joint_0"], ARM_INDEX["joint_0"] + len(POSTURE_RAD))
BENCHMARKS = [name for name in registry.BENCHMARKS if registry.benchmark(name).moves_arm]
PAGE = (Path(__file__).parents[3] / "docs" / "languages.md").read_text("utf-8")
EXAMPLE = re.compile(r"^```python\n(from arm import .*?)^```$", re.MULTILINE | re.DOTALL)


def run(
    program: tuple[bytes, str], isolation: IsolationLevel, benchmark: str = "recover-v1"
) -> tuple[RunOutcome, list[float]]:
    """Return how a run ended, and the joints at its end [rad]."""
    rows: list[np.ndarray] = []
    callbacks = Callbacks(rows=lambda some: rows.append(some.copy()))
    outcome = evaluated(*program, SHORT, isolation, benchmark=benchmark, callbacks=callbacks)
    return outcome, rows[-1][-1, MOTORS].tolist() if rows else []


@cache
def in_python(isolation: IsolationLevel) -> RunOutcome:
    starter = starters(moves_arm=True)["python"]
    return run((starter.upload(), starter.upload_name), isolation)[0]


@pytest.mark.parametrize("language", starters(moves_arm=True))
def test_the_starter_of_every_language_moves_the_arm_into_its_posture_to_the_same_bits(
    language: str, isolation: IsolationLevel, tmp_path: Path
) -> None:
    program = built(starters(moves_arm=True)[language], tmp_path)

    outcome, joints = run(program, isolation)

    assert (outcome.failure, outcome.sentence) == (None, "")
    assert outcome.digest == in_python(isolation).digest
    assert joints == pytest.approx(POSTURE_RAD, abs=0.02)


@pytest.mark.parametrize("benchmark", BENCHMARKS)
def test_the_starter_runs_in_every_benchmark_whose_programs_move_an_arm(
    benchmark: str, isolation: IsolationLevel
) -> None:
    starter = starters(moves_arm=True)["python"]

    outcome, joints = run((starter.upload(), starter.upload_name), isolation, benchmark)

    assert (outcome.failure, outcome.sentence) == (None, "")
    assert joints == pytest.approx(POSTURE_RAD, abs=0.02)


def test_the_program_in_the_documentation_brings_the_tool_to_its_point(
    isolation: IsolationLevel,
) -> None:
    [example] = EXAMPLE.findall(PAGE)
    archive = zipped({"main.py": example.encode(), **helper("python")})
    kinematics = ArmKinematics(
        data_of(load_linkage("arm-5e-like")), mount_of(load("girona500"), "arm-5e-like")
    )

    outcome, joints = run((archive, "controller.zip"), isolation)

    assert (outcome.failure, outcome.sentence) == (None, "")
    assert kinematics.tool(joints).point == pytest.approx((1.4, 0.0, 0.8), abs=0.05)
