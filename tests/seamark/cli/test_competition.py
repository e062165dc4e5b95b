"""`seamark competition audit`: says what it checked, and by its exit code whether that is right."""

import json
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner, Result

from seamark.cli.main import cli
from tests.seamark.competitions.audits import document


def audited(folder: Path, content: bytes, *options: str) -> Result:
    (folder / "audit.json").write_bytes(content)
    arguments = ["competition", "audit", str(folder / "audit.json"), *options]
    return CliRunner().invoke(cli, arguments)


def changed(**values: Any) -> bytes:
    return json.dumps(document() | values).encode()


def test_a_sound_file_is_said_to_be_sound(tmp_path: Path) -> None:
    result = audited(tmp_path, changed())

    assert result.exit_code == 0
    assert "good    Round 3 (final): the standings of 4 finalists follow" in result.stdout
    assert result.stdout.endswith("\nNothing is wrong with what can be checked.\n")


def test_what_is_wrong_is_printed_with_exit_code_1(tmp_path: Path) -> None:
    result = audited(tmp_path, changed(frozen_sha256="0" * 64))

    assert result.exit_code == 1
    assert result.stdout.startswith("problem The frozen document does not have the SHA-256")
    assert "\n1 of 18 checks found something wrong; see above.\n" in result.stdout


def test_warnings_alone_leave_a_file_sound(tmp_path: Path) -> None:
    result = audited(tmp_path, changed(standings=None), "--json")

    assert result.exit_code == 0
    told = json.loads(result.stdout)
    assert told["sound"] is True
    assert told["findings"][-1] == {
        "level": "warning",
        "sentence": "Round 3 (final): it has no standings yet.",
    }


def test_json_says_what_is_wrong(tmp_path: Path) -> None:
    result = audited(tmp_path, changed(frozen={}), "--json")

    assert result.exit_code == 1
    told = json.loads(result.stdout)
    assert told["sound"] is False
    assert told["findings"][0]["level"] == "problem"


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (b"PK", "Error: audit.json is no audit file: the file is no JSON: "),
        (changed(title=5), "Error: audit.json cannot be checked: the document: title is no "),
    ],
)
def test_a_file_of_another_kind_is_refused(tmp_path: Path, content: bytes, sentence: str) -> None:
    result = audited(tmp_path, content)

    assert result.exit_code == 2
    assert result.stderr.startswith(sentence)
