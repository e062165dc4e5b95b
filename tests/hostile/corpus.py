"""The hostile programs: a folder and a table for a language's family, for trackers and detectors.

A table says of each program how it ends in a box, and what is seen when it is called outside:

    name = { verdict, says: pattern in the sentence, waits: uses no CPU time (not blamed at once),
             medium: the verdict without control groups, outside: pattern in what it prints, or what
             its caller says (control.py), absent: what some kernels were built without }

Many programs in Python are one function each, in the file of their group (`network_tcp`: `tcp` in
`python/network.py`); the others are files of their own, as all are in other languages.
"""

import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from typing import Any

from seamark.sandbox.languages import LANGUAGES, language_of
from seamark.sandbox.languages.language import CONTROLLER, DETECTOR, TRACKER
from tests.sandbox.host_compiler import zipped
from tests.sandbox.languages.folders import folder_of

HERE = Path(__file__).parent
ROLES = {"trackers": TRACKER, "detectors": DETECTOR}  # folder of programs that get images -> role
FOLDERS = [*dict.fromkeys(folder_of(language) for language in LANGUAGES.values()), *ROLES]
TABLES: dict[str, dict[str, dict[str, Any]]] = {
    folder: tomllib.loads((HERE / f"{folder}.toml").read_text(encoding="utf-8"))
    for folder in FOLDERS
    if (HERE / f"{folder}.toml").exists()  # test_registry.py demands it of each language
}
FRAMES = HERE / "frames"  # what stands around a program that is one function


@dataclass(frozen=True)
class Case:
    """One program with its row of the table."""

    folder: str
    name: str

    def __str__(self) -> str:
        return f"{self.folder}/{self.name}"

    @property
    def expected(self) -> dict[str, Any]:
        return TABLES[self.folder][self.name]

    @property
    def role(self) -> str:
        return ROLES.get(self.folder, CONTROLLER)

    @property
    def path(self) -> Path:
        """Return the file that the program is in."""
        name = self.name if "." in self.name else f"{self.name}.py"
        own = HERE / self.folder / name
        return own if own.exists() else own.with_name(f"{self.name.partition('_')[0]}.py")

    @property
    def attack(self) -> str:
        """Return the name of the function if its file has several."""
        return "" if self.path.stem == self.name.partition(".")[0] else self.name.partition("_")[2]

    @property
    def config(self) -> dict[str, object]:
        return {"kp": 0.5, "attack": self.attack}

    @cached_property
    def source(self) -> bytes:
        """Return the whole text of the program."""
        text = self.path.read_bytes()
        if self.attack and b"\nclass Controller" not in text:
            return text + b"\n\n" + (FRAMES / "controller.py").read_bytes()
        return text if self.role == CONTROLLER else self._framed(text)

    def _framed(self, text: bytes) -> bytes:
        """Return a tracker or detector, with what stands around it if it is one function."""
        suffix = self.path.suffix.replace(".cpp", ".c")
        frame = (FRAMES / f"{self.role}{suffix}").read_bytes()
        if suffix == ".m":
            return text + frame
        if suffix == ".c":
            return frame + text if b" attack(const" in text else text
        if f"\nclass {self.role.capitalize()}".encode() in text:
            return text
        return b"\n\n".join((text, (FRAMES / "answers.py").read_bytes(), frame))

    @property
    def upload(self) -> tuple[str, bytes]:
        """Return what its owner uploads: the program as it is, or an FMU with it as its source."""
        if self.folder != "fmu":
            return self.path.name, self.source
        common = HERE / self.folder / "common"
        members = {
            "modelDescription.xml": (common / "modelDescription.xml").read_bytes(),
            "sources/fmu.h": (common / "fmu.h").read_bytes(),
            "sources/model.c": (common / "model.c").read_bytes(),
            f"sources/{self.name}": self.source,
        }
        return f"{self.name.removesuffix('.c')}.fmu", zipped(members)

    @property
    def language(self) -> str:
        return language_of(self.upload[0]) or ""


CASES = [Case(folder, name) for folder, table in TABLES.items() for name in sorted(table)]


def case(name: str) -> Case:
    """Return a program in Python by its name."""
    return Case("python", name)


@cache
def programs(folder: str) -> set[str]:
    """Return the names of the programs that there are in a folder."""
    return {*_programs(folder)}


def _programs(folder: str) -> Iterator[str]:
    for path in (HERE / folder).iterdir():
        if not path.is_file():
            continue
        if folder != "python":
            yield path.name
        elif "\nHELD = " in (text := path.read_text("utf-8")):
            listed = _functions(text)
            yield from (f"{path.stem}_{name}" for name in listed)
        elif "\nANSWERS = {" in text:
            names: dict[str, Any] = {}
            exec(text, names)  # noqa: S102
            yield from (f"{path.stem}_{name}" for name in names["ANSWERS"])
        else:
            yield path.stem


def _functions(text: str) -> Iterator[str]:
    """Yield the names of the functions that are given the observation: the attacks."""
    for line in text.splitlines():
        if line.startswith("def ") and line.endswith("(observation):"):
            yield line.removeprefix("def ").partition("(")[0]
