"""Static checks of a MATLAB program: its text is inspected, nothing is run."""

import re
from collections.abc import Mapping

from seamark.programs.diagnostics import Diagnostic

# After nothing but empty lines and comments
_CLASS = re.compile(rb"\A((?:[ \t]*(?:[%#][^\n]*)?\r?\n)*)[ \t]*classdef\b")
_FUNCTIONS = {
    "controller": "controller_step",
    "tracker": "tracker_start and tracker_update",
    "detector": "detector_detect",
}


def lint(files: Mapping[str, bytes], main: str, role: str) -> list[Diagnostic]:
    """Return the problems found in the main file: it has to consist of functions."""
    definition = _CLASS.match(files[main])
    if definition is None:
        return []
    line = definition[1].count(b"\n") + 1
    sentence = (
        f"This file defines a class. A program in MATLAB is a file of functions: write "
        f"{_FUNCTIONS[role]}, which keep their data in the structure `state`."
    )
    return [Diagnostic(sentence=sentence, file=main, line=line)]
