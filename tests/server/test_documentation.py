"""The documentation for operators names every setting."""

from pathlib import Path

import pytest

from seamark import server
from seamark.server.settings import Settings

HOSTING = Path(server.__file__).resolve().parents[1] / "docs" / "hosting.md"


def test_the_documented_table_of_settings_is_up_to_date() -> None:
    assert Settings.table() in HOSTING.read_text(encoding="utf-8")


@pytest.mark.parametrize("name", sorted(Settings.model_fields))
def test_every_setting_has_a_meaning(name: str) -> None:
    assert Settings.model_fields[name].description
