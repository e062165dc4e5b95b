"""The form of a draft: fields to the values of a document, and a document back to fields.

A round is a fieldset whose fields begin with its key. Practice and the final are optional, and have
a box to tick; a document of a file may have several rounds of practice.
"""

import re
import unicodedata
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Any

from seamark.competitions import zones
from seamark.competitions.document import CompetitionDocument, Final, Round, RoundKind
from seamark.sim.settings.own_files import LIBRARIES

NAME_MAX = 56  # [character] of a suggested name without its version
# Entry of a document -> field. A field "question" would be asked before the form is sent.
_TEXTS = {
    name: name
    for name in ("name", "title", "rules", "zone", "programs", "ties", "team_size", "methods")
} | {"question": "asks"}
_OTHERS = ("rounds", "picture", "document", *LIBRARIES)  # fields that may be wrong too
_OF_ROUND = ("opens", "closes", "quota", "trials", "board")
_OF_FINAL = ("opens", "trials", "batches", "finalists", "carry")
_WEEK = timedelta(days=7)


@dataclass(frozen=True, slots=True)
class RoundFields:
    """The fieldset of a round."""

    key: str  # start of the names of its fields
    kind: RoundKind

    @property
    def is_optional(self) -> bool:
        """Whether it has a box that says that there is such a round."""
        return self.kind is not RoundKind.QUALIFICATION

    @property
    def names(self) -> tuple[str, ...]:
        """The entries of the round in a document, which the fieldset has."""
        return _OF_FINAL if self.kind is RoundKind.FINAL else _OF_ROUND


def fieldsets(posted: Mapping[str, str]) -> list[RoundFields]:
    """Return the fieldsets of a form, in the order of their rounds."""
    keys = sorted(
        {name.partition(".")[0] for name in posted if re.match(r"practice[1-9]\.", name)}
    ) or ["practice1"]
    return [
        *(RoundFields(key, RoundKind.PRACTICE) for key in keys),
        RoundFields("qualification", RoundKind.QUALIFICATION),
        RoundFields("final", RoundKind.FINAL),
    ]


def defaults(now: datetime) -> dict[str, str]:
    """Return the fields of a new draft: a week of practice, a week of qualification, a final."""
    begin = now.astimezone(UTC).replace(minute=0, second=0, microsecond=0) + timedelta(hours=1)
    times = {
        "practice1": (begin, begin + _WEEK),
        "qualification": (begin + _WEEK, begin + 2 * _WEEK),
    }
    fields = {"zone": "UTC", "source": "benchmark", "practice1.used": "on", "final.used": "on"}
    for key, (opens, closes) in times.items():
        fields |= {f"{key}.opens": _local(opens, "UTC"), f"{key}.closes": _local(closes, "UTC")}
    return fields | {"final.opens": _local(begin + 2 * _WEEK + timedelta(days=1), "UTC")}


def of_document(document: CompetitionDocument) -> dict[str, str]:
    """Return the fields that give a document."""
    values = document.canonical()
    fields = {field: str(values[name]) for name, field in _TEXTS.items()}
    fields |= {"benchmark": document.benchmark, "source": "kept"}
    practice = 0
    for one in document.rounds:
        practice += one.kind is RoundKind.PRACTICE
        key = f"practice{practice}" if one.kind is RoundKind.PRACTICE else str(one.kind)
        fields |= {f"{key}.{name}": text for name, text in _round_fields(one, document.zone)}
    return fields


def values_of(posted: Mapping[str, str]) -> dict[str, Any]:
    """Return the values of a document in a posted form, without benchmark and settings.

    What is left empty has its default; a name is suggested from the title.
    """
    texts = {name: posted.get(field, "").strip() for name, field in _TEXTS.items()}
    values: dict[str, Any] = {name: text for name, text in texts.items() if text}
    if "name" not in values and "title" in values:
        values["name"] = suggested_name(values["title"])
    if "rules" in values:
        values["rules"] = values["rules"].replace("\r\n", "\n")
    values["rounds"] = [
        {"kind": str(one.kind)}
        | {
            name: posted[f"{one.key}.{name}"].strip()
            for name in one.names
            if posted.get(f"{one.key}.{name}", "").strip()
        }
        for one in _used(posted)
    ]
    return values


def field_of(place: str, posted: Mapping[str, str]) -> str:
    """Return the field at which an error is shown; empty if there is none for it.

    Parameters
    ----------
    place
        As `DocumentInvalid.errors` has it: title, rounds.0.opens, settings.levels.
    """
    first, _, rest = place.partition(".")
    if first == "rounds" and rest:
        number, _, name = rest.partition(".")
        used = _used(posted)
        if number.isdecimal() and int(number) < len(used) and name in used[int(number)].names:
            return f"{used[int(number)].key}.{name}"
        return "rounds"
    elsewhere = {"settings": "source", "benchmark": "source", "vehicle": "vehicle_file"}
    return _TEXTS.get(first) or elsewhere.get(first) or (first if first in _OTHERS else "")


def suggested_name(title: str) -> str:
    """Return the name of the first version of a competition with this title; maybe not valid."""
    plain = unicodedata.normalize("NFKD", title).encode("ascii", "ignore").decode().lower()
    words = re.sub(r"[^a-z0-9]+", "-", plain).strip("-")
    start = words if words[:1].isalpha() else f"cup-{words}".strip("-")
    return f"{start[:NAME_MAX].rstrip('-')}-v1"


def _used(posted: Mapping[str, str]) -> list[RoundFields]:
    return [
        one
        for one in fieldsets(posted)
        if not one.is_optional or posted.get(f"{one.key}.used") == "on"
    ]


def _round_fields(one: Round | Final, zone: str) -> Iterator[tuple[str, str]]:
    yield "used", "on"
    for name in type(one).model_fields.keys() - {"kind"}:
        value = getattr(one, name)
        yield name, _local(value, zone) if isinstance(value, datetime) else str(value)


def _local(at: datetime, zone: str) -> str:
    """Return a time as the value of an input of the type datetime-local."""
    return zones.in_zone(at.timestamp(), zone).strftime("%Y-%m-%dT%H:%M")
