"""Commands of a vehicle with an arm: the speeds of joints follow the vehicle's four numbers."""

import struct

import pytest

from seamark.sandbox.box import Box
from seamark.sandbox.compilation import compiled
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.languages.fmu.inside.description import read
from seamark.sandbox.languages.fmu.inside.wiring import wired
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import Outcome, ProgramEnded, Verdict
from seamark.sandbox.protocol import answers, messages
from seamark.sandbox.protocol.messages import MessageInvalid
from tests.sandbox.conftest import LAYOUT, VALUES, program
from tests.sandbox.languages.fmu.test_fmu import ENOUGH, fmu, scalar
from tests.services.languages import skip_without

JOINTS = {"command": [*LAYOUT["command"], "shoulder", "elbow"], "joint_limits": [0.5, 0.25]}
WITH_ARM = LAYOUT | JOINTS
C = '#include <math.h>\n#include "seamark.h"\n'
C += "int seamark_step(const seamark_observation *o, seamark_command *c) {\n"
C += "    c->surge = o->error[0]; c->arm[0] = %s; c->arm[1] = %s;\n    return 0;\n}\n"
MATLAB = "function [command, state] = controller_step(state, observation)\n"
MATLAB += "    command = [observation.error(1), 0, 0, 0%s];\nend\n"


def source(language: str, shoulder: str, elbow: str) -> bytes:
    """A program that moves the joints at these speeds."""
    if language == "python":
        return program(step=f"return [observation.error[0], 0, 0, 0, float('{shoulder}'), {elbow}]")
    if language == "c":
        return (C % (shoulder.replace("nan", "NAN"), elbow)).encode()
    return (MATLAB % f", {shoulder}, {elbow}").encode()


def commanded(language: str, isolation: IsolationLevel, text: bytes) -> tuple[float, ...] | Outcome:
    """The command that a program gives in one step, or how it ended."""
    skip_without(language, isolation)
    limits, name = Limits(), {"python": "a.py", "c": "a.c", "matlab": "a.m"}[language]
    if language == "c":
        text = compiled(language, text, name, isolation=isolation)
    with Box(language, limits=limits, isolation=isolation) as box:
        try:
            box.load(text, name, {}, WITH_ARM)
            box.reset({"index": 0})
            return box.step(VALUES)
        except ProgramEnded as end:
            return end.outcome


@pytest.mark.host
@pytest.mark.parametrize("language", ["python", "c", "matlab"])
def test_the_speeds_of_joints_follow_the_vehicles_four_numbers(
    language: str, isolation: IsolationLevel
) -> None:
    command = commanded(language, isolation, source(language, "-0.5", "0.125"))

    assert command == (1.0, 0.0, 0.0, 0.0, -0.5, 0.125)


@pytest.mark.host
@pytest.mark.parametrize("language", ["python", "c", "matlab"])
@pytest.mark.parametrize(("shoulder", "elbow"), [("nan", "0.0"), ("0.0", "0.26")])
def test_a_speed_that_is_no_number_or_beyond_its_limit_is_the_programs_failure(
    language: str, shoulder: str, elbow: str, isolation: IsolationLevel
) -> None:
    outcome = commanded(language, isolation, source(language, shoulder, elbow))

    assert isinstance(outcome, Outcome)
    assert outcome.verdict is Verdict.PROTOCOL_ERROR
    assert "0.25" in outcome.sentence if elbow != "0.0" else "nan" in outcome.sentence.lower()


@pytest.mark.host
@pytest.mark.parametrize("language", ["python", "matlab"])
def test_a_command_with_one_of_two_joints_is_told_what_belongs_to_it(
    language: str, isolation: IsolationLevel
) -> None:
    five = program(step="return [0, 0, 0, 0, 0.1]")
    if language == "matlab":
        five = (MATLAB % ", 0.1").encode()

    outcome = commanded(language, isolation, five)

    assert isinstance(outcome, Outcome)
    assert outcome.verdict is Verdict.PROTOCOL_ERROR
    assert "6 finite" in outcome.sentence


@pytest.mark.parametrize(
    "numbers", [(0.0,) * 4, (0.0,) * 7, (0, 0, 0, 0, 0.51, 0), (0,) * 5 + (float("nan"),)]
)
def test_the_simulator_takes_no_other_command_whatever_the_program_sends(
    numbers: tuple[float, ...],
) -> None:

    data = messages.message(messages.COMMAND, 1, struct.pack(f"<{len(numbers)}d", *numbers))

    with pytest.raises(MessageInvalid):
        answers.command(data, (1e6,) * 4 + (0.5, 0.25))


def test_outputs_of_an_fmu_are_connected_to_joints_by_their_names() -> None:
    data = fmu(ENOUGH + scalar("elbow", "output", 3))

    wiring = wired(read(data), WITH_ARM, {})

    assert [(one.variable.name, one.span.offset) for one in wiring.outputs] == [
        ("surge", 0),
        ("sway", 1),
        ("elbow", 5),
    ]
    assert wiring.limits == (1e6, 1e6, 1e6, 1e6, 0.5, 0.25)
