"""Controllers that steer by images: the same run in every language, to the bit."""

import re
from functools import cache
from pathlib import Path

import pytest

from seamark.sandbox.compilation import compiled
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.worker.ipc.outcomes import RunOutcome
from tests.sandbox import host_compiler
from tests.services.languages import skip_without
from tests.worker.evaluation.languages import evaluated

pytestmark = pytest.mark.host

PAGE = Path(__file__).parents[3] / "docs" / "languages.md"
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
ENDINGS = {"python": ["py"], "c": ["c", "cpp"], "matlab": ["m"]}
SHORT = {
    "arm": "alpha-like",
    "vehicle": "bluerov2-heavy-v2",
    "images": "both",
    "levels": [0.1, 0.2],
    "level_duration_s": 2.0,
    "settle_s": 1.0,
    "tracker": "truth",
}
# The forearm by the mean of a row of the arm's camera, surge by a column of the vehicle's, as long
# as the images are not old; yaw by whether they are new.
PROGRAMS = {
    "controller.py": b"""\
class Controller:
    def __init__(self, config):
        assert config["images"] == "both"
        self.last = -1.0

    def step(self, o):
        row, column = o.images["arm"][200], o.images["vehicle"][:, 100]
        elbow = 0.25 * (row.sum() / row.size / 256.0 - 0.25)
        surge = 0.5 * (column.sum() / column.size / 256.0 - 0.5)
        new, self.last = o.image_t != self.last, o.image_t
        age = o.t - o.image_t
        return [surge if age < 0.125 else 0.0, age, 0.0, 0.125 * new, 0.0, 0.0, elbow, 0.0, 0.0]
""",
    "controller.c": b"""\
#include "seamark.h"
static double last = -1.0;
int seamark_step(const seamark_observation *o, seamark_command *c) {
    const seamark_image *arm = &o->images.arm, *vehicle = &o->images.vehicle;
    double row = 0.0, column = 0.0, age = o->t - o->image_t;
    if (arm->channels != 1 || vehicle->channels != 1) return 1;
    for (int x = 0; x < arm->width; x++) row += arm->pixels[200 * arm->width + x];
    for (int y = 0; y < vehicle->height; y++) column += vehicle->pixels[y * vehicle->width + 100];
    c->arm[2] = 0.25 * (row / arm->width / 256.0 - 0.25);
    c->surge = age < 0.125 ? 0.5 * (column / vehicle->height / 256.0 - 0.5) : 0.0;
    c->sway = age;
    c->yaw_rate = o->image_t != last ? 0.125 : 0.0;
    last = o->image_t;
    return 0;
}
""",
    "controller.cpp": b"""\
#include "seamark.h"
#include <numeric>
static double last = -1.0;
int seamark_step(const seamark_observation *o, seamark_command *c) {
    const seamark_image &vehicle = o->images.vehicle, &arm = o->images.arm;
    const unsigned char *begin = arm.pixels + 200 * arm.width;
    double row = std::accumulate(begin, begin + arm.width, 0), column = 0.0;
    double age = o->t - o->image_t;
    for (int y = 0; y < vehicle.height; y++) column += vehicle.pixels[y * vehicle.width + 100];
    c->arm[2] = 0.25 * (row / arm.width / 256.0 - 0.25);
    c->surge = age < 0.125 ? 0.5 * (column / vehicle.height / 256.0 - 0.5) : 0.0;
    c->sway = age;
    c->yaw_rate = o->image_t != last ? 0.125 : 0.0;
    last = o->image_t;
    return 0;
}
""",
    "controller.m": b"""\
function state = controller_setup(config)
    state.last = -1;
end
function [command, state] = controller_step(state, o)
    row = double(o.images.arm(201, :));
    column = double(o.images.vehicle(:, 101));
    age = o.t - o.image_t;
    elbow = 0.25 * (sum(row) / numel(row) / 256 - 0.25);
    surge = 0.5 * (sum(column) / numel(column) / 256 - 0.5);
    if age >= 0.125, surge = 0; end
    command = [surge, age, 0, 0.125 * (o.image_t != state.last), 0, 0, elbow, 0, 0];
    state.last = o.image_t;
end
""",
}


def of_the_page() -> dict[str, bytes]:
    """Return the programs of the section about images, by the name of their file."""
    text = PAGE.read_text("utf-8").partition("## Images for a controller")[2].partition("\n## ")[0]
    blocks = {language: code.encode() for language, code in BLOCK.findall(text)}
    return {f"controller.{end}": blocks[name] for name in ENDINGS for end in ENDINGS[name]}


def run(content: bytes, name: str, isolation: IsolationLevel, **settings: object) -> RunOutcome:
    return evaluated(content, name, SHORT | settings, isolation)


@cache
def in_python(isolation: IsolationLevel) -> RunOutcome:
    return run(PROGRAMS["controller.py"], "controller.py", isolation)


@pytest.mark.parametrize("name", PROGRAMS)
def test_a_program_steers_by_its_images_in_every_language_to_the_same_bits(
    name: str, isolation: IsolationLevel
) -> None:
    outcome = run(PROGRAMS[name], name, isolation)

    assert (outcome.failure, outcome.sentence) == (None, "")
    assert outcome.digest == in_python(isolation).digest


def test_an_executable_is_given_the_same_images(isolation: IsolationLevel) -> None:
    skip_without("c", isolation)
    content = compiled("c", PROGRAMS["controller.c"], "controller.c", isolation=isolation)

    outcome = run(content, "controller.elf", isolation)

    assert (outcome.failure, outcome.sentence) == (None, "")
    assert outcome.digest == in_python(isolation).digest


def test_another_row_of_pixels_gives_another_run(isolation: IsolationLevel) -> None:
    other = PROGRAMS["controller.py"].replace(b"[200]", b"[201]")

    outcome = run(other, "controller.py", isolation)

    assert outcome.failure is None
    assert outcome.digest != in_python(isolation).digest


@cache
def python_of_the_page(isolation: IsolationLevel) -> RunOutcome:
    return run(of_the_page()["controller.py"], "controller.py", isolation, images="arm")


@pytest.mark.parametrize("name", of_the_page())
def test_the_programs_of_the_page_turn_the_arm_alike_in_every_language(
    name: str, isolation: IsolationLevel
) -> None:
    outcome = run(of_the_page()[name], name, isolation, images="arm")

    assert (outcome.failure, outcome.sentence) == (None, "")
    assert outcome.digest == python_of_the_page(isolation).digest
    assert outcome.digest != in_python(isolation).digest


BLIND = PROGRAMS["controller.py"].replace(b'config["images"] == "both"', b"True")
BLIND = BLIND.replace(b'o.images["arm"][200], o.images["vehicle"][:, 100]', b"o.rates, o.error")
BLIND = BLIND.replace(b"o.image_t", b"o.dt")


def test_a_program_that_ignores_its_images_runs_as_without_them(isolation: IsolationLevel) -> None:
    without, one, both = (
        run(BLIND, "controller.py", isolation, images=images) for images in ("none", "arm", "both")
    )

    assert (without.failure, without.sentence) == (None, "")
    assert without.digest == one.digest == both.digest


ASKING = b"""\
class Controller:
    def __init__(self, config):
        self.seen = []

    def reset(self, level):
        self.seen = []

    def step(self, o):
        image = o.images["arm"]
        assert o["images"]["arm"] is image and list(o)[-2:] == ["image_t", "images"]
        assert (image.shape, image.dtype.name) == ((240, 320), "uint8")
        assert not image.flags.writeable
        new = not self.seen or o.image_t != self.seen[-1][0]
        if new:
            self.seen.append((o.image_t, image, image.copy()))
        for _t, kept, copied in self.seen[-2:]:
            assert (kept == copied).all()
        if len(self.seen) == 3:
            assert (self.seen[0][1] != self.seen[0][2]).any()
            o.images["wrist"]
        return [0.0] * 4
"""


@pytest.mark.parametrize(
    ("images", "words"),
    [
        ("arm", "KeyError: images has no key 'wrist'; it has arm (line"),
        ("none", "an observation has no 'images'; it has t, "),
    ],
)
def test_an_image_is_kept_until_the_next_but_one_and_what_is_no_image_is_named(
    images: str, words: str, isolation: IsolationLevel
) -> None:
    outcome = run(ASKING, "controller.py", isolation, images=images)

    assert outcome.failure == "user_error"
    assert words in outcome.sentence


def test_an_fmu_is_refused_images_with_the_languages_that_get_them(
    isolation: IsolationLevel, tmp_path: Path
) -> None:
    outcome = run(host_compiler.fmu("fmi2", tmp_path), "pi.fmu", isolation, images="vehicle")

    assert outcome.failure == "compile_error"
    assert "images" in outcome.sentence
    assert "Python, C, C++, MATLAB (by GNU Octave), Executable" in outcome.sentence
