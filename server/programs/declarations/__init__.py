"""Reading the parameters that a program declares, without running it: a reader per language."""

from collections.abc import Callable, Mapping

from seamark.sandbox.languages.c_family import CPP, C
from seamark.sandbox.languages.fmu import FMU
from seamark.sandbox.languages.matlab import MATLAB
from seamark.sandbox.languages.python import PYTHON
from seamark.server.programs.declarations import comments, fmu, python
from seamark.server.programs.declarations.declared import Declared

_READERS: Mapping[str, Callable[[bytes, str], Declared]] = {
    PYTHON.name: python.read,
    C.name: comments.read,
    CPP.name: comments.read,
    MATLAB.name: comments.read,
    FMU.name: fmu.read,
}


def read(language: str, source: bytes, filename: str) -> Declared:
    """Return the parameters of a program, and what is wrong with their declarations.

    Parameters
    ----------
    source
        The main file; of an FMU the whole archive.
    """
    reader = _READERS.get(language)
    return Declared() if reader is None else reader(source, filename)
