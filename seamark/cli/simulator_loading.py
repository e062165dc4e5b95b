"""Says what happens before a run makes progress: loading the simulator, or compiling it first."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from seamark.progress import Progress

COMPILING = "compiling the simulator (once; a minute or two)"


@contextmanager
def loading_shown(bar: Progress) -> Iterator[None]:
    """Show on a bar what the simulator does before it runs; say if OpenCV is not the right one."""
    say_other_opencv()
    bar.show(0.0, "loading the simulator", state="loading")
    from seamark.sim.numerics.compilation import announced

    def show(functions: int) -> None:
        bar.show(0.0, f"{COMPILING}, {functions} functions", state="compiling")

    with announced(show):
        yield


def say_other_opencv() -> None:
    """Say on standard error if `import cv2` brings another OpenCV than Seamark requires."""
    from seamark.sim.recording.opencv import complaint

    if says := complaint():
        click.echo(says, err=True)


@contextmanager
def compiling_said(say: Callable[[str], None]) -> Iterator[None]:
    """Pass on a sentence if the simulator has to be compiled, or if OpenCV is not the right one."""
    say_other_opencv()
    from seamark.sim.numerics.compilation import announced

    def note(functions: int) -> None:
        if functions == 1:
            say(f"{COMPILING.capitalize()}.")

    with announced(note):
        yield
