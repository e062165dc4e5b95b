"""Whether this host can run a language: its self-test program must give the expected answers.

As a controller, to one step: half the error. In the other roles that the language has, to one
image: as a tracker, the corners moved by the first pixel of the second row; as a detector, one
detection whose corners count on from that pixel. If the configuration asks for `contents`, it
prints a line for each component of its box: kind, name, version, with tabs between.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, fields
from typing import Any

from seamark.sandbox.box import Box
from seamark.sandbox.compilation import compiled
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.languages import LANGUAGES
from seamark.sandbox.languages.language import DETECTOR, TRACKER
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import ProgramEnded, SandboxBroken
from seamark.sandbox.protocol.answers import Detection

LIMITS = Limits(cpu_s=10.0, wall_s=20.0, memory_mib=192, processes=12)
LAYOUT = {
    "observation": [["t", 0], ["error", 3]],
    "command": ["surge", "sway", "heave", "yaw_rate"],
}
OBSERVATION = (0.0, 1.0, -2.0, 3.0)
COMMAND = (0.5, -1.0, 1.5, 0.0)  # half the error
KINDS = ("interpreter", "compiler", "library")
COMPILER = "compiler"
WIDTH, SECOND_ROW = 7, 3  # [px] of the image; grey value
IMAGE = bytes(WIDTH) + bytes([SECOND_ROW]) * WIDTH
CORNERS = ((1.0, 2.0), (3.0, 2.5), (3.0, 4.0), (1.0, 4.0))  # [px]
MOVED = tuple((x + SECOND_ROW, y + SECOND_ROW) for x, y in CORNERS)
FOUND = [Detection("row", ((3.0, 4.0), (5.0, 6.0), (7.0, 8.0), (9.0, 10.0)), 0.5)]


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
        seen = {
            role: answer({"role": role}, ask)[0]
            for role, (ask, _) in _IMAGE_ROLES.items()
            if role in known.roles
        }
    except (SandboxBroken, ProgramEnded) as error:
        return Result(str(error))
    if command != COMMAND:
        return Result(f"the self-test answered {command}, not {COMMAND}")
    for role, answered in seen.items():
        if answered != (expected := _IMAGE_ROLES[role][1]):
            return Result(f"the self-test's {role} answered {answered}, not {expected}")
    compiles = known.compiler is not None
    components = tuple(one for one in _components(printed) if compiles or one.kind != COMPILER)
    return Result("", components)


def _components(printed: bytes) -> Iterator[Component]:
    for line in printed.decode("utf-8", "replace").splitlines():
        parts = line.split("\t")
        if len(parts) == len(fields(Component)) and parts[0] in KINDS:
            yield Component(*parts)


def _track(box: Box) -> object:
    box.start(_image(), CORNERS)
    return box.update(_image())


def _detect(box: Box) -> object:
    return box.detect(_image())


def _image() -> memoryview:
    return memoryview(IMAGE).cast("B", (2, WIDTH))


# role that gets images -> what is asked, and the expected answer
_IMAGE_ROLES: Mapping[str, tuple[Callable[[Box], object], object]] = {
    TRACKER: (_track, MOVED),
    DETECTOR: (_detect, FOUND),
}
