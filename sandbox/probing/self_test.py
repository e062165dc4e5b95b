"""Whether this host can run a language: its self-test program must give the expected answers.

As a controller, to one step: half the error. As a tracker, if the language has that role, to one
image: the corners moved by the first pixel of the second row. If the configuration asks for
`contents`, it prints a line for each component of its box: kind, name, version, with tabs between.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields
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
KINDS = ("interpreter", "compiler", "library")
COMPILER = "compiler"
TRACKER_LAYOUT = {"role": TRACKER}
WIDTH, SECOND_ROW = 7, 3  # [px] of the image; grey value
IMAGE = bytes(WIDTH) + bytes([SECOND_ROW]) * WIDTH
CORNERS = ((1.0, 2.0), (3.0, 2.5), (3.0, 4.0), (1.0, 4.0))  # [px]
MOVED = tuple((x + SECOND_ROW, y + SECOND_ROW) for x, y in CORNERS)


@dataclass(frozen=True, slots=True)
class Component:
    """An interpreter, a compiler or a library that programs find in a box."""

    kind: str  # "interpreter", "compiler" or "library"
    name: str
    version: str


@dataclass(frozen=True, slots=True)
class Result:
    """Why programs in a language cannot run here, empty if they can; and what they find then."""

    why_not: str
    contents: tuple[Component, ...] = ()


def tried(language: str, isolation: IsolationLevel) -> Result:
    """Run the self-test of a language."""
    known = LANGUAGES[language]
    name = known.self_test.upload_name

    def answer(
        layout: dict[str, Any], ask: Callable[[Box], object], *, contents: bool = False
    ) -> tuple[object, bytes]:
        with Box(language, limits=LIMITS, isolation=isolation) as box:
            box.load(program, name, {"contents": contents}, layout)
            return ask(box), box.finish().output

    try:
        source = known.self_test.upload()
        program = compiled(known.sample_compiler, source, name, isolation=isolation)
        command, printed = answer(LAYOUT, lambda box: box.step(OBSERVATION), contents=True)
        moved = answer(TRACKER_LAYOUT, _track)[0] if TRACKER in known.roles else MOVED
    except (SandboxBroken, ProgramEnded) as error:
        return Result(str(error))
    if command != COMMAND:
        return Result(f"the self-test answered {command}, not {COMMAND}")
    if moved != MOVED:
        return Result(f"the self-test's tracker answered {moved}, not {MOVED}")
    compiles = known.compiler is not None
    components = tuple(one for one in _components(printed) if compiles or one.kind != COMPILER)
    return Result("", components)


def _components(printed: bytes) -> Iterator[Component]:
    for line in printed.decode("utf-8", "replace").splitlines():
        parts = line.split("\t")
        if len(parts) == len(fields(Component)) and parts[0] in KINDS:
            yield Component(*parts)


def _track(box: Box) -> object:
    image = memoryview(IMAGE).cast("B", (2, WIDTH))
    box.start(image, CORNERS)
    return box.update(image)
