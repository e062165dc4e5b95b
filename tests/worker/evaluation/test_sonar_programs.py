"""Controllers that steer by the sonar: the same run in every language, to the bit."""

from functools import cache

import pytest

from seamark.sandbox.isolation.level import IsolationLevel
from seamark.worker.ipc.outcomes import RunOutcome
from tests.worker.evaluation.languages import evaluated

pytestmark = pytest.mark.host

SHORT = {
    "sonar": "forward",
    "levels": [0.1],
    "level_duration_s": 2.0,
    "vehicle": "bluerov2-heavy-v2",
}
# Surge by a beam, yaw by a row of range; heave is the age of the image.
PROGRAMS = {
    "controller.py": b"""\
class Controller:
    def __init__(self, config):
        assert config["sonar"] == "forward" and config["sonar_range_m"] == 30.0

    def step(self, o):
        image = o.images["sonar"]
        assert image.shape == (400, 256)
        surge, yaw = image[:, 100].sum() / 65536.0, image[200].sum() / 65536.0
        return [surge, 0.0, o.t - o.image_t, yaw]
""",
    "controller.c": b"""\
#include "seamark.h"
int seamark_step(const seamark_observation *o, seamark_command *c) {
    const seamark_image *image = &o->images.sonar;
    double beam = 0.0, row = 0.0;
    if (image->channels != 1 || image->height != 400 || image->width != 256) return 1;
    if (o->images.vehicle.pixels || o->images.arm.pixels) return 2;
    for (int y = 0; y < 400; y++) beam += image->pixels[y * 256 + 100];
    for (int x = 0; x < 256; x++) row += image->pixels[200 * 256 + x];
    c->surge = beam / 65536.0;
    c->heave = o->t - o->image_t;
    c->yaw_rate = row / 65536.0;
    return 0;
}
""",
    "controller.m": b"""\
function state = controller_setup(config)
    state = config.sonar_range_m;
end
function [command, state] = controller_step(state, o)
    image = double(o.images.sonar);
    command = [sum(image(:, 101)) / 65536, 0, o.t - o.image_t, sum(image(201, :)) / 65536];
end
""",
}


# The same source is a program of both; an executable is built as its author would.
PROGRAMS["controller.cpp"] = PROGRAMS["controller.c"]


@cache
def in_python(isolation: IsolationLevel) -> RunOutcome:
    return run("controller.py", isolation)


def run(name: str, isolation: IsolationLevel, **settings: object) -> RunOutcome:
    return evaluated(PROGRAMS[name], name, SHORT | settings, isolation, benchmark="track-v1")


@pytest.mark.parametrize("name", PROGRAMS)
def test_a_program_steers_by_the_sonar_in_every_language_to_the_same_bits(
    name: str, isolation: IsolationLevel
) -> None:
    outcome = run(name, isolation)

    assert (outcome.failure, outcome.sentence) == (None, "")
    assert outcome.digest == in_python(isolation).digest


def test_another_tilt_gives_another_run(isolation: IsolationLevel) -> None:
    outcome = run("controller.py", isolation, sonar_tilt_rad=0.5)

    assert outcome.failure is None
    assert outcome.digest != in_python(isolation).digest
