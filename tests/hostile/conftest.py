"""Runs a hostile program for real, as a worker would: one trial of some steps or images."""

import os
from collections.abc import Callable
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from seamark.sandbox.box import Box
from seamark.sandbox.compilation import compiled
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.isolation.process_tree import Layers
from seamark.sandbox.languages.language import CONTROLLER, DETECTOR, TRACKER
from seamark.sandbox.limits import COMPILING, Limits
from seamark.sandbox.outcome import Outcome, ProgramEnded, Verdict
from tests.hostile.corpus import Case, case
from tests.services.languages import skip_without

STEPS, IMAGES = 20, 6
LAYOUT = {
    "observation": [["t", 0], ["error", 3], ["depth", 0], ["target_visible", 0]],
    "booleans": ["target_visible"],
    "command": ["surge", "sway", "heave", "yaw_rate"],
}
CORNERS = [[10.0, 20.0], [30.0, 20.0], [30.0, 40.0], [10.0, 40.0]]
LIMITS = Limits(
    cpu_s=0.2,  # dozens of programs really use it up
    wall_s=20.0,
    start_wall_s=5.0,
    step_wall_s=0.7,
    memory_mib=128,
    processes=16,
    output_kib=4,
    output_max_mib=1,
)

# For programs that end by themselves or by another limit: a slow or busy host must not make them
# end by time.
LONG_WAITS = replace(LIMITS, cpu_s=5.0, start_wall_s=20.0, step_wall_s=10.0)
# For programs that do nothing until they are stopped: the less they wait, the sooner it is over.
SHORT_WAITS = replace(LIMITS, start_wall_s=2.0)
MEMORY_MIB = {"matlab": 256}  # Octave has 180 MiB of address space by itself
COMPILER = replace(COMPILING, cpu_s=1.2)  # the bombs would use up any limit


class Ended(NamedTuple):
    """How a program ended, and the numbers that it answered."""

    outcome: Outcome
    answers: list[object]


Run = Callable[..., Ended]


@pytest.fixture(scope="session")
def run_case(isolation: IsolationLevel) -> Run:
    """Return a function that compiles and runs one program of the corpus."""

    def run_one(
        program: Case, *, at: IsolationLevel = isolation, limits: Limits | None = None
    ) -> Ended:
        skip_without(program.language, isolation)
        name, source = program.upload
        answers: list[object] = []
        try:
            binary = compiled(program.language, source, name, isolation=at, limits=COMPILER)
            with Box(program.language, limits=limits or limits_for(program), isolation=at) as box:
                serve = SERVED[program.role]
                return Ended(serve(box, binary, name, program.config, answers), answers)
        except ProgramEnded as end:
            return Ended(end.outcome, answers)

    return run_one


@pytest.fixture(scope="session")
def run(isolation: IsolationLevel) -> Callable[..., Outcome]:
    """Return a function that runs a program in Python, without one of the layers if need be."""

    def run_one(
        program: str | Path,
        *,
        layers: Layers | None = None,
        limits: Limits = LONG_WAITS,
        **config: object,
    ) -> Outcome:
        if isinstance(program, str):
            name, source, config = program, case(program).source, case(program).config
        else:
            name, source = program.stem, program.read_bytes()
        with Box(limits=limits, isolation=isolation, layers=layers) as box:
            try:
                return stepped(box, source, f"{name}.py", config, [])
            except ProgramEnded as end:
                return end.outcome

    return run_one


def limits_for(program: Case) -> Limits:
    """Return the limits for a program of a table."""
    limits = LONG_WAITS
    if program.expected["verdict"] == Verdict.TIME_LIMIT:
        limits = SHORT_WAITS if program.expected.get("waits") else LIMITS
    memory_mib = MEMORY_MIB.get(program.language, limits.memory_mib)
    return replace(limits, memory_mib=memory_mib)


def stepped(
    box: Box, source: bytes, name: str, config: dict[str, object], answers: list[object]
) -> Outcome:
    """Ask a controller for commands."""
    box.load(source, name, config, LAYOUT)
    box.reset({"index": 0})
    for step in range(STEPS):
        answers.append(box.step([step / 20, 0.1, 0.2, 0.3, 5.0, 1.0]))
    return box.finish()


def followed(
    box: Box, source: bytes, name: str, config: dict[str, object], answers: list[object]
) -> Outcome:
    """Show a tracker some images."""
    image = np.zeros((240, 320), np.uint8)
    box.load(source, name, config, {"role": "tracker"})
    box.start(image, CORNERS)
    for value in range(IMAGES):
        image[:] = value
        answers.append(box.update(image))
    return box.finish()


def looked_through(
    box: Box, source: bytes, name: str, config: dict[str, object], answers: list[object]
) -> Outcome:
    """Show a detector some images."""
    image = np.zeros((240, 320), np.uint8)
    box.load(source, name, config, {"role": "detector"})
    for value in range(IMAGES):
        image[:] = value
        found = box.detect(image)
        assert all(one.label.isprintable() for one in found)
        answers += [(*chain(*one.corners), one.confidence) for one in found]
    return box.finish()


SERVED = {CONTROLLER: stepped, TRACKER: followed, DETECTOR: looked_through}


@pytest.fixture
def secret(monkeypatch: pytest.MonkeyPatch) -> str:
    """Put a secret into the worker's environment and return it."""
    monkeypatch.setenv("SEAMARK_SECRET_KEY", "do-not-tell")
    assert os.environ["SEAMARK_SECRET_KEY"] == "do-not-tell"
    return "do-not-tell"
