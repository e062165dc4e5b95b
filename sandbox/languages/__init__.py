"""The languages that a program may be written in: a folder each, and a line each here."""

from collections.abc import Iterable
from pathlib import PurePosixPath

from seamark.sandbox.languages.c_family import CPP, C
from seamark.sandbox.languages.executable import EXECUTABLE
from seamark.sandbox.languages.fmu import FMU
from seamark.sandbox.languages.language import CONTROLLER, Language
from seamark.sandbox.languages.matlab import MATLAB
from seamark.sandbox.languages.python import PYTHON
from seamark.sandbox.languages.sample import Sample

LANGUAGES: dict[str, Language] = {
    language.name: language for language in (PYTHON, C, CPP, MATLAB, FMU, EXECUTABLE)
}

DEFAULT_LANGUAGE = next(iter(LANGUAGES))  # of the form and of `seamark init`


def language_of(filename: str) -> str | None:
    """Return the name of the language with the file's suffix; None if there is none."""
    suffix = PurePosixPath(filename).suffix.lower()
    for language in LANGUAGES.values():
        if suffix in language.suffixes:
            return language.name
    return None


def role_refusal(name: str, role: str) -> str:
    """Return why no program of this role can be written in a language; empty if it can."""
    known = LANGUAGES.get(name)
    if known is not None and role in known.roles:
        return ""
    labels = ", ".join(each.label for each in LANGUAGES.values() if role in each.roles)
    return f"A {role} can be written in {labels}, but not in {known.label if known else name}."


def images_refusal(name: str) -> str:
    """Return why no controller in a language can be given images; empty if it can."""
    if LANGUAGES[name].gets_images:
        return ""
    labels = ", ".join(each.label for each in LANGUAGES.values() if each.gets_images)
    return (
        "The setting images gives a controller images, which it can get in "
        f"{labels}, but not in {LANGUAGES[name].label}. Set images to none."
    )


def kinds(names: Iterable[str]) -> str:
    """Return in words what a program in one of these languages is, such as: C or an FMU."""
    words = [LANGUAGES[name].described for name in names]
    return " or ".join(filter(None, (", ".join(words[:-1]), *words[-1:])))


def starters(role: str = CONTROLLER, *, moves_arm: bool = False) -> dict[str, Sample]:
    """Return the programs to start from, by their names for `seamark init --language`."""
    return {
        one.name or language.name: one
        for language in LANGUAGES.values()
        for one in language.starters
        if one.role == role and one.moves_arm == moves_arm
    }


def editor_starters(role: str, *, moves_arm: bool = False) -> dict[str, Sample]:
    """Return the programs that the form's editor starts with, by language: those of one text."""
    texts = {
        name: language.starter(role, moves_arm=moves_arm) for name, language in LANGUAGES.items()
    }
    return {name: one for name, one in texts.items() if one and LANGUAGES[name].is_text}
