"""docs/competitions.md names every entry of an organiser's file with its default."""

import json
import re
from enum import Enum
from pathlib import Path

import pytest
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from seamark.cli.competition_files import FILES
from seamark.competitions.document import CompetitionDocument, Final, Round

GUIDE = (Path(__file__).parents[3] / "docs/competitions.md").read_text()
FILE = GUIDE.partition("### The file\n")[2].partition("\n## ")[0]
ROWS = {
    name: cells
    for line in FILE.splitlines()
    if line.startswith("| `")
    for cells in [[cell.strip() for cell in line[2:].split("|")]]
    for name in re.findall(r"`(\w+)`", line.partition(" | ")[0])
}


def default_of(field: FieldInfo) -> str:
    """Return the default as the table has it; empty if there is none."""
    if field.is_required():
        return ""
    value = field.get_default(call_default_factory=True)
    value = value.value if isinstance(value, Enum) else value
    return "none" if value == {} else f"`{json.dumps(value)}`"


@pytest.mark.parametrize("part", [CompetitionDocument, Round, Final])
def test_every_entry_is_documented_with_its_default(part: type[BaseModel]) -> None:
    for name, field in part.model_fields.items():
        default = default_of(field)

        assert name in ROWS
        assert default in "".join(ROWS[name][1:])
        assert bool(default) == bool(ROWS[name][1])


def test_no_other_entry_is_documented() -> None:
    known = {name for part in (CompetitionDocument, Round, Final) for name in part.model_fields}

    assert set(ROWS) - known == {*FILES}
