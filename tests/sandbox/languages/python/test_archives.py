"""An archive as a program: unpacked inside the box, with its modules and data beside it."""

from collections.abc import Iterator

import pytest

from seamark.programs.archives import normal_form
from seamark.sandbox.box import Box
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import ProgramEnded, Verdict
from tests.hostile.uploads.archives import damaged, zipped

pytestmark = pytest.mark.host

LAYOUT = {"observation": [["t", 0]], "command": ["surge", "sway", "heave", "yaw_rate"]}
MAIN = """
from pathlib import Path
from law.pid import answer

class Controller:
    def __init__(self, config):
        self.gain = float(Path("gain.txt").read_text())
        beside = Path(__file__).with_name("gain.txt")
        print("beside", beside.read_text())
    def step(self, observation):
        return answer(self.gain)
"""
GOOD = "def answer(gain):\n    return [gain, 0.0, 0.0, 0.0]\n"
ALONE = b"""
from law import answer

class Controller:
    def __init__(self, config):
        pass
    def step(self, observation):
        return answer(0.5)
"""
LIMITS = Limits()


def packed(**files: str) -> bytes:
    plain = {"main.py": MAIN, "gain.txt": "0.25", "law/__init__.py": "", "law/pid.py": GOOD}
    plain |= {name.replace("__", "/").replace("_py", ".py"): text for name, text in files.items()}
    return normal_form({name: text.encode() for name, text in plain.items()}, limits=LIMITS)


@pytest.fixture
def box(isolation: IsolationLevel) -> Iterator[Box]:
    with Box(limits=LIMITS, isolation=isolation) as made:
        yield made


def test_modules_and_data_of_an_archive_are_there(box: Box) -> None:
    box.load(packed(), "mine.zip", {}, LAYOUT)

    assert box.step([0.0]) == (0.25, 0.0, 0.0, 0.0)
    assert box.take_output() == b"beside 0.25\n"


def test_an_archive_may_have_controller_py_instead_of_main_py(box: Box) -> None:
    alone = normal_form({"controller.py": ALONE, "law.py": GOOD.encode()}, limits=LIMITS)

    box.load(alone, "mine.zip", {}, LAYOUT)

    assert box.step([0.0]) == (0.5, 0.0, 0.0, 0.0)


def test_a_program_may_copy_its_files_with_their_attributes(box: Box) -> None:
    copying = MAIN + "import shutil\nprint('copied to', shutil.copy2('gain.txt', 'copy.txt'))\n"

    box.load(packed(main_py=copying), "mine.zip", {}, LAYOUT)
    box.step([0.0])

    assert box.take_output().startswith(b"copied to copy.txt\n")


def end_of(box: Box, blob: bytes) -> ProgramEnded:
    def run() -> None:
        box.load(blob, "mine.zip", {}, LAYOUT)
        box.step([0.0])

    with pytest.raises(ProgramEnded) as end:
        run()
    return end.value


def test_an_error_is_shown_with_the_files_of_the_archive(box: Box) -> None:
    outcome = end_of(box, packed(law__pid_py="def answer(gain):\n    return 1 / 0\n")).outcome

    assert outcome.sentence == "ZeroDivisionError: division by zero (line 2 of law/pid.py)"
    assert 'File "main.py", line 11, in step' in outcome.traceback
    assert 'File "law/pid.py", line 2, in answer\n    return 1 / 0' in outcome.traceback
    assert "/tmp" not in outcome.traceback


def test_a_syntax_error_in_a_module_is_shown_with_its_line(box: Box) -> None:
    outcome = end_of(box, packed(law__pid_py="def answer(:\n")).outcome

    assert 'File "law/pid.py", line 1' in outcome.traceback
    assert outcome.verdict in (Verdict.USER_ERROR, Verdict.COMPILE_ERROR)


def test_an_invalid_archive_ends_with_an_explanation(box: Box) -> None:
    outcome = end_of(box, b"PK\x03\x04" + bytes(100)).outcome

    assert outcome.verdict is Verdict.COMPILE_ERROR
    assert "cannot be unpacked" in outcome.sentence


def test_an_archive_with_damaged_compressed_data_ends_with_an_explanation(box: Box) -> None:
    outcome = end_of(box, zipped(damaged(b"main.py"))).outcome

    assert outcome.verdict is Verdict.COMPILE_ERROR
    assert "cannot be unpacked" in outcome.sentence
