"""What an operator or a user may have to know stands in the documentation."""

from dataclasses import fields
from pathlib import Path

import pytest

import seamark.server.pages.docs
from seamark.sandbox.limits import MEANING, Limits
from seamark.server.pages.docs import PAGES
from seamark.server.settings import Settings

HOSTING = Path(seamark.server.__file__).resolve().parents[1] / "docs" / "hosting.md"


def test_the_table_of_settings_is_the_one_that_the_settings_make() -> None:
    assert Settings.table() in HOSTING.read_text(encoding="utf-8")


@pytest.mark.parametrize("name", sorted(Settings.model_fields))
def test_every_setting_has_a_meaning(name: str) -> None:
    assert Settings.model_fields[name].description


def test_every_limit_has_a_meaning_and_a_row_of_its_own() -> None:
    names = [field.name for field in fields(Limits)]

    shown = list(seamark.server.pages.docs.limits_of(Limits()))

    assert set(MEANING) == set(names)
    assert len({limit.name for limit in shown}) == len(shown) == len(names)
    assert all(limit.meaning for limit in shown)
    assert "controller" in PAGES
