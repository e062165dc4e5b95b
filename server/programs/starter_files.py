"""The programs that the editor, the documentation and `seamark init` begin with."""

import io
import zipfile
from functools import cache
from pathlib import Path

from seamark import templates
from seamark.sandbox import languages

# Of the editor: role -> language whose programs are one text -> name of the file.
FILES = {
    "controller": {
        "python": "controller.py",
        "c": "controller.c",
        "c++": "controller.cpp",
        "matlab": "controller.m",
    },
    "tracker": {
        "python": "tracker.py",
        "c": "tracker.c",
        "c++": "tracker.cpp",
        "matlab": "tracker.m",
    },
}
OTHERS = {  # written in C too; an executable is compiled by its author
    "embedded-c": "embedded_c/controller.c",
    "executable": "executable.c.txt",
}
_HEADER = Path(languages.__file__).parent / "native" / "seamark.h"
_FOLDER = Path(templates.__file__).parent / "submit"
_LONG_AGO = (1980, 1, 1, 0, 0, 0)  # the same bytes whenever an archive is made


@cache
def of(language: str, role: str = "controller") -> str:
    """Return a program that works as it stands.

    A controller is PI on the position error, a tracker looks for a patch of the first picture.
    """
    return (_FOLDER / f"{FILES[role][language]}.txt").read_text("utf-8")


@cache
def header() -> str:
    """Return seamark.h, the interface of programs in C and C++."""
    return _HEADER.read_text("utf-8")


def start(kind: str, role: str = "controller") -> dict[str, bytes]:
    """Return the files that somebody begins with, first the one to upload or to compile.

    Raises
    ------
    KeyError
        If there is no program of that role in that language.
    """
    if role == "controller" and kind == "fmu":
        return _fmu()
    if role == "controller" and kind in OTHERS:
        return {"controller.c": (_FOLDER / OTHERS[kind]).read_bytes()}
    files = {FILES[role][kind]: of(kind, role).encode()}
    if kind in ("c", "c++"):
        files["seamark.h"] = header().encode()
    return files


def _fmu() -> dict[str, bytes]:
    source, description = (
        (_FOLDER / "fmu" / name).read_bytes() for name in ("controller.c", "modelDescription.xml")
    )
    members = {"modelDescription.xml": description, "sources/controller.c": source}
    return {"controller.fmu": _zipped(members), **members}


def _zipped(members: dict[str, bytes]) -> bytes:
    whole = io.BytesIO()
    with zipfile.ZipFile(whole, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in members.items():
            archive.writestr(zipfile.ZipInfo(name, _LONG_AGO), content)
    return whole.getvalue()


KINDS = (*FILES["controller"], "fmu", *OTHERS)  # what `seamark init` can write
