"""The languages that a program may be written in: one small file each, one line here."""

from pathlib import PurePosixPath

from seamark.sandbox.languages.c import C
from seamark.sandbox.languages.cpp import CPP
from seamark.sandbox.languages.executable import EXECUTABLE
from seamark.sandbox.languages.fmu import FMU
from seamark.sandbox.languages.language import Language
from seamark.sandbox.languages.matlab import MATLAB
from seamark.sandbox.languages.python import PYTHON

LANGUAGES: dict[str, Language] = {
    language.name: language for language in (PYTHON, C, CPP, MATLAB, FMU, EXECUTABLE)
}


def language_of(filename: str) -> str | None:
    """Return the name of the language of a file by its suffix; None if there is none for it."""
    suffix = PurePosixPath(filename).suffix.lower()
    for language in LANGUAGES.values():
        if suffix in language.suffixes:
            return language.name
    return None
