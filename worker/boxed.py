"""A program in a box as the simulator sees it."""

from collections.abc import Callable, Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from sandbox.box import Box
from sandbox.compilation import compiled
from sandbox.limits import Limits
from sandbox.outcome import Outcome
from sim.program import Command
from worker.job import Place


class BoxLike(Protocol):
    """What is needed of a box; tests have one without a sandbox."""

    def load(  # noqa: D102 - see sandbox.box.Box
        self,
        source: bytes,
        filename: str,
        config: Mapping[str, object],
        layout: Mapping[str, object],
    ) -> None: ...
    def reset(self, level: Mapping[str, object]) -> None: ...  # noqa: D102
    def step(self, values: Any) -> Command: ...  # noqa: D102
    def finish(self) -> Outcome: ...  # noqa: D102
    def take_output(self) -> bytes: ...  # noqa: D102
    def close(self) -> None: ...  # noqa: D102


MakeBox = Callable[[str, Limits], BoxLike]
Compile = Callable[[str, bytes, str], bytes]  # language, source, file name -> what a box runs


class Boxed:
    """A `sim.program.Program` over a box."""

    def __init__(self, box: BoxLike) -> None:
        self._box = box

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Pass the level on; raises ProgramEnded."""
        self._box.reset(level)

    def step(self, values: NDArray[np.float64]) -> Command:
        """Pass the observation on and return the checked answer; raises ProgramEnded."""
        return self._box.step(values)


# role of a program -> what makes of its box something that takes part in a benchmark
SOLUTIONS: Mapping[str, Callable[[BoxLike], Any]] = {"controller": Boxed}


def real_boxes(place: Place) -> MakeBox:
    """Return how boxes are made on this host: on the core of the process that makes them."""

    def make(language: str, limits: Limits) -> Box:
        return Box(language, limits=limits, level=place.level)

    return make


def real_compiler(place: Place) -> Compile:
    """Return how programs are compiled on this host; raises ProgramEnded if one cannot be."""

    def compile_program(language: str, source: bytes, filename: str) -> bytes:
        return compiled(language, source, filename, level=place.level, core=place.core)

    return compile_program


def as_it_is(language: str, source: bytes, filename: str) -> bytes:
    """Return the source: nothing is compiled."""
    return source
