"""Whether this host can run a language: its self-test program must answer right.

As a controller one step: half the error. As a tracker, where the language can, one image: the
corners moved by what the second line of the image begins with.
"""

from collections.abc import Callable
from typing import Any

from seamark.sandbox.box import Box
from seamark.sandbox.compilation import compiled
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.languages import LANGUAGES
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import ProgramEnded, SandboxBroken

LIMITS = Limits(cpu_s=10.0, wall_s=20.0, memory_mib=192, processes=12)
LAYOUT = {
    "observation": [["t", 0], ["error", 3]],
    "command": ["surge", "sway", "heave", "yaw_rate"],
}
OBSERVATION = (0.0, 1.0, -2.0, 3.0)
COMMAND = (0.5, -1.0, 1.5, 0.0)  # half the error
TRACKER = {"role": "tracker"}
WIDTH, SECOND_LINE = 7, 3  # [px] of the image; grey value
IMAGE = bytes(WIDTH) + bytes([SECOND_LINE]) * WIDTH
CORNERS = ((1.0, 2.0), (3.0, 2.5), (3.0, 4.0), (1.0, 4.0))  # [px]
MOVED = tuple((x + SECOND_LINE, y + SECOND_LINE) for x, y in CORNERS)


def why_not(language: str, isolation: IsolationLevel) -> str:
    """Return why programs in this language cannot be run here; empty if they can."""
    known = LANGUAGES[language]
    name = f"self_test{known.suffixes[0]}"

    def answer(layout: dict[str, Any], ask: Callable[[Box], object]) -> object:
        with Box(language, limits=LIMITS, isolation=isolation) as box:
            box.load(program, name, {}, layout)
            said = ask(box)
            box.finish()
        return said

    try:
        test = known.self_test
        source = test.encode() if isinstance(test, str) else test()
        program = compiled(known.tested_by or language, source, name, isolation=isolation)
        command = answer(LAYOUT, lambda box: box.step(OBSERVATION))
        moved = answer(TRACKER, _track) if TRACKER["role"] in known.roles else MOVED
    except (SandboxBroken, ProgramEnded) as error:
        return str(error)
    if command != COMMAND:
        return f"the self-test answered {command}, not {COMMAND}"
    return "" if moved == MOVED else f"the self-test's tracker answered {moved}, not {MOVED}"


def _track(box: Box) -> object:
    image = memoryview(IMAGE).cast("B", (2, WIDTH))
    box.start(image, CORNERS)
    return box.update(image)
