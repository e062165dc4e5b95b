"""What a simulator child needs to know to evaluate one run. No secret, no database, no broker."""

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Self

from seamark.sandbox.languages import DEFAULT_LANGUAGE

_PATHS = ("program", "vehicle", "bridge")


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
    vehicle: Path | None = None  # file of a user's own, which `config` names
    check: bool = False  # two simulated seconds only (see check.py)
    bridge: Path | None = None  # Unix socket at which the program connects (see bridged.py)

    def to_json(self) -> bytes:
        """Return the job as a packet."""
        paths = {name: getattr(self, name) for name in _PATHS}
        texts = {name: str(path) if path else None for name, path in paths.items()}
        return json.dumps(asdict(self) | texts).encode()

    @classmethod
    def from_json(cls, packet: bytes) -> Self:
        """Return the job that `to_json` was given."""
        values = json.loads(packet)
        paths = {name: Path(values[name]) for name in _PATHS if values[name]}
        return cls(**values | paths | {"seeds": tuple(values["seeds"])})
