"""Kinematics of the arms for the author of a program: a file in each language that can have one.

The numbers of every arm with a tool, and of where each vehicle carries it, are written into the
file from theirs. Python gets the simulator's own arithmetic, C and MATLAB translations of it.
"""

from collections.abc import Callable

from seamark.programs.arm_helpers import c_header, matlab_function, python_module
from seamark.programs.arm_helpers.known_arms import KnownArms, known_arms
from seamark.sandbox.languages.c_family import CPP, C
from seamark.sandbox.languages.matlab import MATLAB
from seamark.sandbox.languages.python import PYTHON

_HELPERS: dict[str, tuple[str, Callable[[KnownArms], str]]] = {
    PYTHON.name: (python_module.NAME, python_module.text),
    C.name: (c_header.NAME, c_header.text),
    CPP.name: (c_header.NAME, c_header.text),
    MATLAB.name: (matlab_function.NAME, matlab_function.text),
}


def helper(language: str) -> dict[str, bytes]:
    """Return name -> content of the file with the kinematics in a language; empty without one."""
    if language not in _HELPERS:
        return {}
    name, text = _HELPERS[language]
    return {name: text(known_arms()).encode()}
