"""MATLAB programs: their inputs arrive unchanged, in one file or in several."""

import json
import shutil
import struct
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from seamark.sandbox.box import Box
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.languages.matlab import host
from seamark.sandbox.languages.matlab.inside.relay import octave_value
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import Outcome, ProgramEnded
from seamark.sandbox.runtime import BindMount, alternatives
from tests.sandbox.host_compiler import zipped
from tests.services.languages import skip_without

LAYOUT = {
    "observation": [["t", 0], ["new_field", 2], ["error", 3], ["target_visible", 0]],
    "booleans": ["target_visible"],
    "command": ["surge", "sway", "heave", "yaw_rate"],
}
VALUES = [0.25, 8.0, 9.0, 1.0, 2.0, 3.0, 1.0]
CONFIG = {
    "note": 'a "quoted" %d\n\\ text',
    "levels": [0.0, 0.1],
    "mixed": [1.0, "b"],
    "kp": 0.1,
    "small": 1e-300,
    "on": True,
    "größe": 1.0,
}
STEP = """\
function [command, state] = controller_step(state, observation)
    command = [0, 0, 0, 0];
    %s
end
"""


def test_every_library_that_is_linked_through_etc_is_in_the_box(tmp_path: Path) -> None:
    (tmp_path / "libplain.so.1").touch()
    (tmp_path / "libbeside.so.1").symlink_to(tmp_path / "libplain.so.1")
    (tmp_path / "libgone.so.1").symlink_to("/etc/alternatives/of-nothing")
    (tmp_path / "libchosen.so.0").symlink_to("/etc/hostname")

    assert alternatives(tmp_path) == [BindMount(Path("/etc/hostname"), "/etc/hostname")]


@pytest.fixture(scope="module")
def octave(isolation: IsolationLevel) -> IsolationLevel:
    skip_without("matlab", isolation)
    return isolation


def ended(source: bytes, isolation: IsolationLevel) -> Outcome:
    with Box("matlab", limits=Limits(), isolation=isolation) as box:
        try:
            box.load(source, "mine.m", CONFIG, LAYOUT)
            box.reset({"index": 2, "count": 5, "duration_s": 120.0, "dt": 0.05, "t": 240.0})
            box.step(VALUES)
            return box.finish()
        except ProgramEnded as end:
            return end.outcome


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_a_number_as_text_is_the_same_number(number) -> None:
    assert struct.pack("<d", float(octave_value(number))) == struct.pack("<d", number)


@given(st.text())
def test_a_text_cannot_break_out_of_its_quotes(text) -> None:
    value = octave_value(json.loads(json.dumps(text, ensure_ascii=False)))

    assert set(value) <= set('"\\01234567')
    octal = value[1:-1].split("\\")[1:]
    assert bytes(int(digits, 8) for digits in octal) == text.encode("utf-8")


@pytest.mark.host
def test_a_program_sees_its_configuration_its_level_and_its_observation(octave) -> None:
    program = (
        """\
function state = controller_setup(config)
    printf("%s|%g|%d|%s|%d\\n", config.note, config.levels(2), config.kp == 0.1, ...
           class(config.mixed), isfield(config, "größe"));
    state = config.on;
end

function state = controller_reset(state, level)
    printf("%d %d %g %g\\n", state, level.index, level.dt, level.t);
end

"""
        + STEP % 'printf("%g %g %g %s\\n", observation.error, class(observation.target_visible));'
    )

    outcome = ended(program.encode(), octave)

    assert outcome.output.decode() == (
        'a "quoted" %d\n\\ text|0.1|1|cell|0\n1 2 0.05 240\n1 2 3 logical\n'
    )


@pytest.mark.host
def test_other_files_of_an_archive_are_functions_with_lines_of_their_own(octave) -> None:
    helper = b"function x = helper(y)\n    x = y.nothing;\nend\n"
    main = (STEP % "command(1) = helper(observation);").encode()

    outcome = ended(zipped({"controller.m": main, "helper.m": helper}), octave)

    assert outcome.sentence.endswith("(line 2 of helper.m)")
    assert "controller_step at line 3 of controller.m" in outcome.traceback


@pytest.mark.host
def test_a_program_may_keep_its_state_itself_and_return_a_column(octave) -> None:
    program = (
        b"function command = controller_step(state, observation)\n    command = zeros(4, 1);\nend\n"
    )

    assert ended(program, octave).sentence == "The program ended well."


@pytest.fixture
def slow_relay(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, octave: IsolationLevel
) -> Iterator[IsolationLevel]:
    """Let the relay hand on a failure half a second late, as on a machine that is busy."""
    inside = tmp_path / "matlab" / "inside"
    shutil.copytree(host.INSIDE, inside)
    relay = inside / "relay.py"
    line = "elif letter == FAILED:\n"
    late = line + '        __import__("time").sleep(0.5)\n'
    assert line in relay.read_text()
    relay.write_text(relay.read_text().replace(line, late))
    monkeypatch.setattr(host, "INSIDE", inside)
    host.octave_runtime.cache_clear()
    yield octave
    host.octave_runtime.cache_clear()


@pytest.mark.host
@pytest.mark.parametrize(
    ("program", "says"),
    [
        ("function [c, s] = controller_step(s, o)\n    c = (3;\nend\n", "line 2: syntax error"),
        (STEP % 'error("too deep")', "too deep"),
        (STEP % "command = 7;", "controller_step returned"),
    ],
)
def test_octave_waits_until_its_failure_is_handed_on(
    program: str, says: str, slow_relay: IsolationLevel
) -> None:
    assert says in ended(program.encode(), slow_relay).sentence


@pytest.mark.host
def test_a_program_whose_relay_is_gone_ends(octave: IsolationLevel) -> None:
    kill = STEP % 'system("pkill -9 python; kill -9 -1"); error("none hears it")'

    assert ended(kill.encode(), octave).verdict != "ok"
