"""Controllers that follow a pipe or enter a dock: the same run in every language, to the bit."""

from functools import cache

import pytest

from seamark.sandbox.isolation.level import IsolationLevel
from seamark.worker.ipc.outcomes import RunOutcome
from tests.worker.evaluation.languages import evaluated

pytestmark = pytest.mark.host

TASKS: dict[str, dict[str, object]] = {
    "track-v1": {"route": "pipe", "levels": [0.1], "level_duration_s": 3.0},
    # From where the lamps are seen, and with answers so close.
    "dock-v1": {
        **{"levels": [0.1], "level_duration_s": 6.0, "turbidity_1_m": 0.0, "fix_least_m": 0.1},
        **{"approach_least_m": 1.0, "approach_most_m": 1.5},
    },
}
VEHICLE = {"vehicle": "bluerov2-heavy-v2"}
# Each command is a sum of what its task is told, in the same order in each language.
PROGRAMS = {
    ("track-v1", "controller.py"): b"""\
class Controller:
    def __init__(self, config):
        pass

    def step(self, o):
        along = o.error[0] + 0.5 * o.error[1]
        return [0.25 * along, 0.25 * o.pipe_offset, 0.125 * o.error[2], 0.25 * o.pipe_angle]
""",
    ("track-v1", "controller.c"): b"""\
#include "seamark.h"
int seamark_step(const seamark_observation *o, seamark_command *c) {
    double along = o->error[0] + 0.5 * o->error[1];
    c->surge = 0.25 * along;
    c->sway = 0.25 * o->pipe_offset;
    c->heave = 0.125 * o->error[2];
    c->yaw_rate = 0.25 * o->pipe_angle;
    return 0;
}
""",
    ("track-v1", "controller.m"): b"""\
function [command, state] = controller_step(state, o)
    along = o.error(1) + 0.5 * o.error(2);
    command = [0.25 * along, 0.25 * o.pipe_offset, 0.125 * o.error(3), 0.25 * o.pipe_angle];
end
""",
    ("dock-v1", "controller.py"): b"""\
class Controller:
    def __init__(self, config):
        pass

    def step(self, o):
        far = 0.125 * o.dock[0] - 0.125 * o.dock[1]
        near = 0.0625 * o.dock[2] + 0.03125 * o.dock_age + o.dock_sigma
        lamp = (o.light[0] + o.light[1]) / 1024.0 if o.light_visible else -0.5
        turn = o.dock_heading - o.attitude[2]
        return [far, lamp, 0.5 * near, 0.25 * turn]
""",
    ("dock-v1", "controller.c"): b"""\
#include "seamark.h"
int seamark_step(const seamark_observation *o, seamark_command *c) {
    double far = 0.125 * o->dock[0] - 0.125 * o->dock[1];
    double near = 0.0625 * o->dock[2] + 0.03125 * o->dock_age + o->dock_sigma;
    double lamp = o->light_visible ? (o->light[0] + o->light[1]) / 1024.0 : -0.5;
    c->surge = far;
    c->sway = lamp;
    c->heave = 0.5 * near;
    c->yaw_rate = 0.25 * (o->dock_heading - o->attitude[2]);
    return 0;
}
""",
    ("dock-v1", "controller.m"): b"""\
function [command, state] = controller_step(state, o)
    far = 0.125 * o.dock(1) - 0.125 * o.dock(2);
    near = 0.0625 * o.dock(3) + 0.03125 * o.dock_age + o.dock_sigma;
    lamp = -0.5;
    if o.light_visible
        lamp = (o.light(1) + o.light(2)) / 1024;
    end
    command = [far, lamp, 0.5 * near, 0.25 * (o.dock_heading - o.attitude(3))];
end
""",
}


def run(task: str, name: str, isolation: IsolationLevel, program: bytes = b"") -> RunOutcome:
    content = program or PROGRAMS[task, name]
    return evaluated(content, name, TASKS[task] | VEHICLE, isolation, benchmark=task)


@cache
def in_python(task: str, isolation: IsolationLevel) -> RunOutcome:
    return run(task, "controller.py", isolation)


@pytest.mark.parametrize("task", TASKS)
def test_a_program_is_told_the_same_in_every_language(task: str, isolation: IsolationLevel) -> None:
    names = [name for its_task, name in PROGRAMS if its_task == task]
    outcomes = {name: run(task, name, isolation) for name in names}
    # C++ has the same header, and the same source is a program of it.
    outcomes["controller.cpp"] = run(
        task, "controller.cpp", isolation, PROGRAMS[task, "controller.c"]
    )

    assert [(one.failure, one.sentence) for one in outcomes.values()] == [(None, "")] * 4
    assert len({one.digest for one in outcomes.values()}) == 1


@pytest.mark.parametrize(
    ("task", "told"),
    [
        *(("track-v1", told) for told in ("o.pipe_offset", "o.pipe_angle")),
        *(("dock-v1", told) for told in ("o.dock[0]", "o.dock_age", "o.light[0]")),
    ],
)
def test_what_a_program_is_told_moves_it(task: str, told: str, isolation: IsolationLevel) -> None:
    deaf = PROGRAMS[task, "controller.py"].replace(told.encode(), b"0.0")

    outcome = run(task, "controller.py", isolation, deaf)

    assert outcome.failure is None
    assert outcome.digest != in_python(task, isolation).digest
