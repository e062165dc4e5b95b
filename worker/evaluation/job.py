"""What a simulator child needs to know to evaluate one run. No secret, no database, no broker."""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Self

from seamark.sandbox.languages import DEFAULT_LANGUAGE

_PATHS = ("program", "vehicle", "bridge")


@dataclass(frozen=True, slots=True, kw_only=True)
class PartProgram:
    """A further program of a job, in place of the built-in solution of its role."""

    role: str
    program: Path  # file of the source
    filename: str  # as the user named it
    language: str
    parameters: Mapping[str, Any] = field(default_factory=dict)  # values of those it declares

    def to_json(self) -> dict[str, Any]:
        """Return the program as values that JSON knows."""
        return asdict(self) | {"program": str(self.program)}

    @classmethod
    def from_json(cls, values: dict[str, Any]) -> Self:
        """Return the program that `to_json` was given."""
        return cls(**values | {"program": Path(values["program"])})


@dataclass(frozen=True, slots=True, kw_only=True)
class Job:
    """One evaluation: `seeds[i]` is the seed of trial i."""

    benchmark: str
    config: dict[str, Any]
    seeds: tuple[int, ...]
    ranked: bool = False  # False: one seed in all trials, chosen by the user
    controller: str
    program: Path | None = None  # file of the source; None: the built-in `controller`
    filename: str = ""  # as the user named it
    language: str = DEFAULT_LANGUAGE
    parts: tuple[PartProgram, ...] = ()  # in the order of the benchmark's parts
    vehicle: Path | None = None  # file of a user's own, which `config` names
    files: Mapping[str, Path] = field(default_factory=dict)  # setting -> further file of a user's
    check: bool = False  # two simulated seconds only (see check.py)
    bridge: Path | None = None  # Unix socket at which the program connects (see bridged.py)

    @property
    def languages(self) -> tuple[str, ...]:
        """The language of each uploaded program, that of the controller first."""
        main = () if self.program is None else (self.language,)
        return (*main, *(part.language for part in self.parts))

    def to_json(self) -> bytes:
        """Return the job as a packet."""
        paths = {name: getattr(self, name) for name in _PATHS}
        texts = {name: str(path) if path else None for name, path in paths.items()}
        parts = [part.to_json() for part in self.parts]
        files = {setting: str(path) for setting, path in self.files.items()}
        return json.dumps(asdict(self) | texts | {"parts": parts, "files": files}).encode()

    @classmethod
    def from_json(cls, packet: bytes) -> Self:
        """Return the job that `to_json` was given."""
        values = json.loads(packet)
        paths = {name: Path(values[name]) for name in _PATHS if values[name]}
        parts = tuple(map(PartProgram.from_json, values["parts"]))
        files = {setting: Path(text) for setting, text in values["files"].items()}
        seeds = tuple(values["seeds"])
        return cls(**values | paths | {"seeds": seeds, "parts": parts, "files": files})
