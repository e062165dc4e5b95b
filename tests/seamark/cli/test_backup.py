"""`seamark backup` and `seamark restore`."""

import fcntl
import json
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from seamark.cli.main import cli
from seamark.server.database.schema import check_all
from seamark.server.settings import Settings
from tests.cast import Backend


@pytest.fixture
def backups(backend: Backend, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder for backups of a service, which the commands find by their settings."""
    for variable, value in backend.settings.environment().items():
        if "DATABASE" in variable or "BROKER" in variable:
            monkeypatch.setenv(variable, value)
    folder = tmp_path / "backups"
    folder.mkdir()
    return folder


def seamark(*arguments: str | Path) -> Result:
    return CliRunner().invoke(cli, list(map(str, arguments)), prog_name="seamark")


@pytest.mark.slow
def test_a_backup_in_a_folder_is_checked_and_restored_from_the_command_line(
    backend: Backend, backups: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run_id, data = backend.succeeded(), backend.settings.data

    made = seamark("backup", backups, "--data", data, "--json")
    [file] = backups.iterdir()
    monkeypatch.delenv("SEAMARK_DATABASE_URL")
    elsewhere = tmp_path / "elsewhere"
    answers = [
        seamark("restore", file, "--check"),
        seamark("restore", file, "--data", elsewhere),
        seamark("restore", file, "--data", elsewhere),
    ]

    assert json.loads(made.stdout)["rows"]["runs"] == run_id
    assert [answer.exit_code for answer in answers] == [0, 0, 2]
    assert "is complete" in answers[0].output
    assert "6 accounts, 1 run (0 with data), 0 programs." in answers[1].output
    assert "--force" in answers[2].output
    check_all(Settings.model_validate({"data": elsewhere}))
    audit = seamark("audit", "--data", elsewhere)
    assert f"backup_restored  {file.name}" in audit.output


def test_a_service_that_runs_is_not_replaced(backend: Backend, backups: Path) -> None:
    data = backend.settings.data
    assert seamark("backup", backups / "b.tar", "--data", data).exit_code == 0

    with (data / "up.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        answer = seamark("restore", backups / "b.tar", "--force", "--data", data)

    assert answer.exit_code == 2
    assert "already running" in answer.output


def test_a_backup_before_an_update_is_made_by_the_version_that_the_service_has(
    backend: Backend, backups: Path
) -> None:
    data = backend.settings.data
    assert seamark("db", "downgrade", "0031", "--data", data).exit_code == 0

    answer = seamark("backup", backups, "--data", data)

    assert answer.exit_code == 2
    assert "before it is updated" in answer.output
    assert list(backups.iterdir()) == []


@pytest.mark.parametrize("wrong", ["none", "no-folder/b.tar", "text.tar"])
def test_what_cannot_be_backed_up_or_restored_is_refused_with_a_sentence(
    tmp_path: Path, wrong: str
) -> None:
    (tmp_path / "text.tar").write_text("no archive")
    if wrong == "text.tar":
        answer = seamark("restore", tmp_path / wrong, "--data", tmp_path / "data")
    else:
        answer = seamark("backup", tmp_path / wrong, "--data", tmp_path / "data")

    assert answer.exit_code == 2
    assert "Error: " in answer.output
    assert "Traceback" not in answer.output
