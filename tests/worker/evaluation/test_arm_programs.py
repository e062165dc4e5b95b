"""Programs that move an arm by what they feel: the same run in every language, to the bit."""

from functools import cache

import pytest

from seamark.sandbox.isolation.level import IsolationLevel
from seamark.worker.ipc.outcomes import RunOutcome
from tests.worker.evaluation.languages import evaluated

pytestmark = pytest.mark.host

SHORT = {
    "arm": "alpha-like",
    "vehicle": "bluerov2-heavy-v2",
    "levels": [0.1],
    "level_duration_s": 4.0,
    "settle_s": 1.0,
    "tracker": "truth",
}
PROGRAMS = {  # towards a pose of the arm; gentle where the hand feels a force or a touch
    "controller.py": b"""\
class Controller:
    def __init__(self, config):
        assert config["arm"] == "alpha-like"

    def reset(self, level):
        pass

    def step(self, o):
        gain = 0.125 if o.touch[1] or o.wrist_force[2] > 2.0 else 0.25
        elbow = gain * (1.5 - o.joints[2]) - 0.125 * o.joint_speeds[2]
        lift = 0.001 * o.joint_efforts[1] + 0.5 * o.wrist_torque[1]
        surge, sway = 0.5 * o.error[0], 0.5 * o.error[1]
        return [surge, sway, 0.0, 0.0, 0.0, max(-0.4, min(0.4, lift)), elbow, 0.0, -0.5]
""",
    "controller.c": b"""\
#include "seamark.h"
static double within(double x) { return x < -0.4 ? -0.4 : x > 0.4 ? 0.4 : x; }
int seamark_step(const seamark_observation *o, seamark_command *c) {
    if (o->joints_count != 5) return 1;
    double gain = o->touch[1] != 0.0 || o->wrist_force[2] > 2.0 ? 0.125 : 0.25;
    c->arm[2] = gain * (1.5 - o->joints[2]) - 0.125 * o->joint_speeds[2];
    c->arm[1] = within(0.001 * o->joint_efforts[1] + 0.5 * o->wrist_torque[1]);
    c->arm[4] = -0.5;
    c->surge = 0.5 * o->error[0];
    c->sway = 0.5 * o->error[1];
    return 0;
}
""",
    "controller.m": b"""\
function [command, state] = controller_step(state, o)
    gain = 0.25;
    if o.touch(2) || o.wrist_force(3) > 2.0, gain = 0.125; end
    elbow = gain * (1.5 - o.joints(3)) - 0.125 * o.joint_speeds(3);
    lift = max(-0.4, min(0.4, 0.001 * o.joint_efforts(2) + 0.5 * o.wrist_torque(2)));
    command = [0.5 * o.error(1), 0.5 * o.error(2), 0, 0, 0, lift, elbow, 0, -0.5];
end
""",
}
FOUR = {  # as written for a vehicle without an arm
    "controller.py": b"""\
class Controller:
    def __init__(self, config):
        pass

    def reset(self, level):
        pass

    def step(self, o):
        return [0.5 * o.error[0], 0.5 * o.error[1], 0.0, 0.0]
""",
    "array.py": b"""\
import numpy as np

class Controller:
    def __init__(self, config):
        pass

    def reset(self, level):
        pass

    def step(self, o):
        return np.array([0.5 * o.error[0], 0.5 * o.error[1], 0.0, 0.0])
""",
    "controller.m": b"""\
function [command, state] = controller_step(state, o)
    command = [0.5 * o.error(1); 0.5 * o.error(2); 0; 0];
end
""",
}
SIX = PROGRAMS["controller.py"].replace(b"elbow, 0.0, -0.5]", b"elbow]")


def run(content: bytes, name: str, isolation: IsolationLevel) -> RunOutcome:
    return evaluated(content, name, SHORT, isolation)


@cache
def in_python(isolation: IsolationLevel) -> RunOutcome:
    return run(PROGRAMS["controller.py"], "controller.py", isolation)


@cache
def four_in_python(isolation: IsolationLevel) -> RunOutcome:
    return run(FOUR["controller.py"], "controller.py", isolation)


@pytest.mark.parametrize("name", PROGRAMS)
def test_an_arm_is_moved_by_what_it_feels_in_every_language_to_the_same_bits(
    name: str, isolation: IsolationLevel
) -> None:
    outcome = run(PROGRAMS[name], name, isolation)

    assert (outcome.failure, outcome.sentence) == (None, "")
    assert outcome.digest == in_python(isolation).digest


@pytest.mark.parametrize("name", FOUR)
def test_a_program_for_a_vehicle_alone_runs_unchanged_and_its_arm_rests(
    name: str, isolation: IsolationLevel
) -> None:
    outcome = run(FOUR[name], name, isolation)

    assert (outcome.failure, outcome.sentence) == (None, "")
    assert outcome.digest == four_in_python(isolation).digest
    assert outcome.digest != in_python(isolation).digest


def test_a_command_with_some_of_the_joints_ends_the_run_with_a_sentence(
    isolation: IsolationLevel,
) -> None:
    outcome = run(SIX, "controller.py", isolation)

    assert outcome.failure is not None
    assert "7 values" in outcome.sentence
