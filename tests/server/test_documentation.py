"""The documentation for operators names every setting, and what to do about every alert."""

import re
from pathlib import Path

import pytest

from seamark import server
from seamark.server.settings import Settings
from tests.services import promql

HOSTING = Path(server.__file__).resolve().parents[1] / "docs" / "hosting.md"


def test_the_documented_table_of_settings_is_up_to_date() -> None:
    assert Settings.table() in HOSTING.read_text(encoding="utf-8")


@pytest.mark.parametrize("name", sorted(Settings.model_fields))
def test_every_setting_has_a_meaning(name: str) -> None:
    assert Settings.model_fields[name].description


def test_every_alert_says_what_to_do_and_no_other_is_documented() -> None:
    alerts = [rule["alert"] for rule in promql.rules() if "alert" in rule]
    documented = re.findall(r"^\| `(Seamark\w+)` \| ", HOSTING.read_text("utf-8"), re.MULTILINE)

    assert documented == alerts
