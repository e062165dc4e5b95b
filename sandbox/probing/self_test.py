"""Whether this host can run a language: its self-test program must give the expected answers.

As a controller, to one step: half the error. As a tracker, if the language has that role, to one
image: the corners moved by the first pixel of the second row.
"""

from collections.abc import Callable
from typing import Any

from seamark.sandbox.box import Box
from seamark.sandbox.compilation import compiled
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.languages import LANGUAGES
from seamark.sandbox.languages.language import TRACKER
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import ProgramEnded, SandboxBroken

LIMITS = Limits(cpu_s=10.0, wall_s=20.0, memory_mib=192, processes=12)
LAYOUT = {
    "observation": [["t", 0], ["error", 3]],
    "command": ["surge", "sway", "heave", "yaw_rate"],
}
OBSERVATION = (0.0, 1.0, -2.0, 3.0)
COMMAND = (0.5, -1.0, 1.5, 0.0)  # half the error
TRACKER_LAYOUT = {"role": TRACKER}
WIDTH, SECOND_ROW = 7, 3  # [px] of the image; grey value
IMAGE = bytes(WIDTH) + bytes([SECOND_ROW]) * WIDTH
CORNERS = ((1.0, 2.0), (3.0, 2.5), (3.0, 4.0), (1.0, 4.0))  # [px]
MOVED = tuple((x + SECOND_ROW, y + SECOND_ROW) for x, y in CORNERS)


def why_not(language: str, isolation: IsolationLevel) -> str:
    """Return why programs in this language cannot run here; empty if they can."""
    known = LANGUAGES[language]
    name = known.self_test.upload_name

    def answer(layout: dict[str, Any], ask: Callable[[Box], object]) -> object:
        with Box(language, limits=LIMITS, isolation=isolation) as box:
            box.load(program, name, {}, layout)
            answered = ask(box)
            box.finish()
        return answered

    try:
        source = known.self_test.upload()
        program = compiled(known.sample_compiler, source, name, isolation=isolation)
        command = answer(LAYOUT, lambda box: box.step(OBSERVATION))
        moved = answer(TRACKER_LAYOUT, _track) if TRACKER in known.roles else MOVED
    except (SandboxBroken, ProgramEnded) as error:
        return str(error)
    if command != COMMAND:
        return f"the self-test answered {command}, not {COMMAND}"
    return "" if moved == MOVED else f"the self-test's tracker answered {moved}, not {MOVED}"


def _track(box: Box) -> object:
    image = memoryview(IMAGE).cast("B", (2, WIDTH))
    box.start(image, CORNERS)
    return box.update(image)
