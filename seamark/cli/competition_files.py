"""The file in which an organiser writes a competition: read, and one to start from."""

from __future__ import annotations

import json
from datetime import datetime, timedelta, timezone
from pathlib import Path
from typing import Any, NamedTuple

from seamark.failures import UsageRefused

# Entries with the path of a file beside it.
FILES = ("picture", "vehicle", "current_record", "target_texture")
DAY = timedelta(days=1)
STARTER = """\
# A competition. docs/competitions.md describes every entry; those with a # before them have the
# value that is shown. Next:
#   seamark competition check FILE                    says whether the file is valid
#   seamark competition create FILE                   makes a draft, which nobody else sees
#   seamark competition check my-cup-v1 --wait        says what the reference entries show of it
#   seamark competition open my-cup-v1                shows it to everybody, and freezes it

name = "my-cup-v1"  # as in addresses: lower-case letters, digits, hyphens, and the version
title = "My Cup"
question = "Which controller keeps station best in a current that turns?"
rules = [  # a paragraph each; who takes part agrees on them
    "Everybody may take part, alone or in a team.",
    "The programs of the teams stay with them.",
]
zone = "UTC"  # time zone of the times below, and of those that pages show, such as Europe/Madrid
# picture = "cup.png"  # PNG or JPEG, beside this file
# vehicle = "my_rov.toml"  # a vehicle of your own, beside this file
# current_record = "ria.csv"  # a record of currents of your own, beside this file
# target_texture = "logo.png"  # a picture of your own that covers the target, beside this file

benchmark = "currents-v3"  # whose scenario you change
# programs = "hidden"  # who reads the programs of teams: hidden, organiser or public
# ties = "earlier"  # who is first among equals: earlier, or shared places
# team_size = 5  # members at most
# methods = 3  # of a team

[settings]  # of the scenario; what you leave out stays as in the benchmark
levels = [0.0, 0.2, 0.4]
# score = "score - 5 * power_share"  # in place of the score of the benchmark; as in its ranking

[[rounds]]
kind = "practice"  # counts for nothing
opens = {practice}T12:00:00
closes = {qualification}T12:00:00
quota = 20  # submissions of a team
# trials = 8  # of each submission
# board = "visible"  # or hidden, until the round has ended

[[rounds]]
kind = "qualification"  # decides who is in the final
opens = {qualification}T12:00:00
closes = {final}T12:00:00
quota = 5
trials = 8
board = "visible"

[[rounds]]
kind = "final"  # all on the same new trials; nobody submits to it
opens = {final}T12:00:00
trials = 16  # of a batch
batches = 4  # at most: they are added until the ranks separate
finalists = 1  # methods of a team
# carry = "best"  # or chosen, by the captain
"""


class OrganisersFile(NamedTuple):
    """The values of a file, and what it names of other files, such as a picture."""

    values: dict[str, Any]
    files: dict[str, Path]


def starter() -> str:
    """Return a file to start from, whose rounds begin tomorrow."""
    today = datetime.now(timezone.utc).date()
    days = {"practice": 1, "qualification": 15, "final": 43}
    return STARTER.format(**{name: today + days_ * DAY for name, days_ in days.items()})


def read(path: Path) -> OrganisersFile:
    """Return what a TOML or JSON file says.

    Raises
    ------
    UsageRefused
        It cannot be read, or it is neither.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise UsageRefused(f"{path} cannot be read: {error.strerror}.") from None
    values = _toml(path, content) if path.suffix.lower() == ".toml" else _json(path, content)
    named = {name: values.pop(name) for name in FILES if name in values}
    return OrganisersFile(values, {name: _beside(path, name, at) for name, at in named.items()})


def _toml(path: Path, content: bytes) -> dict[str, Any]:
    from seamark.sim.vehicles.toml_reading import TomlRefused, read_toml

    try:
        return read_toml(content)
    except TomlRefused as refusal:
        raise UsageRefused(f"{path}: {refusal}") from None


def _json(path: Path, content: bytes) -> dict[str, Any]:
    try:
        values = json.loads(content)
    except (ValueError, RecursionError) as error:
        raise UsageRefused(f"{path} is neither TOML (name it .toml) nor JSON: {error}.") from None
    if not isinstance(values, dict):
        raise UsageRefused(f"{path} must hold keys and values, not a {type(values).__name__}.")
    return values


def _beside(path: Path, name: str, value: object) -> Path:
    if not isinstance(value, str) or not (path.parent / value).is_file():
        raise UsageRefused(
            f"{path}: {name} is {value!r}, but there is no such file beside it. Correct the path, "
            "or leave the entry out."
        )
    return path.parent / value
