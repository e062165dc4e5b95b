"""The programs that the editor, the documentation and `seamark init` begin with."""

from functools import cache
from pathlib import Path

import sandbox.languages
import templates

FILES = {
    "python": "controller.py",
    "c": "controller.c",
    "c++": "controller.cpp",
    "matlab": "controller.m",
}
_HEADER = Path(sandbox.languages.__file__).parent / "native" / "seamark.h"


@cache
def of(language: str) -> str:
    """Return a controller that works as it stands: PI on the position error."""
    folder = Path(templates.__file__).parent / "submit"
    return (folder / f"{FILES[language]}.txt").read_text("utf-8")


@cache
def header() -> str:
    """Return seamark.h, the interface of programs in C and C++."""
    return _HEADER.read_text("utf-8")
