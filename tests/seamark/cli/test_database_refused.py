"""Commands whose database cannot be used: a sentence and exit code 3, whatever the command."""

import os
from collections.abc import Mapping
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from sqlalchemy import make_url, text

from seamark.cli.main import cli
from seamark.server.database.engine import Database
from seamark.server.settings import Settings
from tests.services.ports import free_port
from tests.services.prepared import SEAMARK, run

COMMANDS = (
    *("web", "worker", "user list", "user add ann", "token new ann", "audit", "backup out.tar"),
    *("db upgrade", "db downgrade 0031", "db rebuild-leaderboard", "db reference-entries"),
)


@pytest.fixture
def environment(settings: Settings) -> Mapping[str, str]:
    return settings.environment()


def _invoke(command: str, environment: Mapping[str, str], url: str = "") -> Result:
    changed = {"SEAMARK_DATABASE_URL": url} if url else {}
    return CliRunner().invoke(cli, command.split(), env={**environment, **changed})


def _sentence(answer: Result) -> str:
    """Return what a command that refused has said: one line, no traceback."""
    assert answer.exit_code == 3, answer.output
    [line] = answer.output.strip().splitlines()
    return line


@pytest.fixture
def newer(database: Database) -> None:
    """The database has been upgraded by a version that this one does not know."""
    with database.writing() as session:
        session.execute(text("UPDATE alembic_version SET version_num = '9999'"))


@pytest.mark.usefixtures("newer")
@pytest.mark.parametrize("command", COMMANDS)
def test_a_database_of_a_newer_version_is_named_as_such(
    environment: Mapping[str, str], command: str
) -> None:
    sentence = _sentence(_invoke(command, environment))

    assert "has the schema 9999, of a newer version of Seamark; this is" in sentence
    assert "`seamark db downgrade" in sentence


@pytest.mark.parametrize("command", COMMANDS)
def test_a_database_that_is_too_early_to_be_upgraded_is_named_as_such(
    database: Database, environment: Mapping[str, str], command: str
) -> None:
    with database.writing() as session:
        session.execute(text("UPDATE alembic_version SET version_num = '0030'"))

    sentence = _sentence(_invoke(command, environment))

    assert "has the schema 0030, of a version before the first release" in sentence
    assert "Run `seamark db upgrade` with the commit 093b11f4" in sentence


@pytest.mark.slow
@pytest.mark.usefixtures("newer")
def test_up_names_a_database_of_a_newer_version(environment: Mapping[str, str]) -> None:
    command = ["up", "--port", str(free_port())]
    alone = {name: value for name, value in environment.items() if "BROKER" not in name}

    done = run(SEAMARK, *command, on="warm", environment=os.environ | alone)

    assert done.returncode == 3
    assert len(done.stderr.strip().splitlines()) == 1
    assert "of a newer version of Seamark" in done.stderr


@pytest.mark.parametrize("command", COMMANDS)
def test_a_database_that_is_away_is_named_with_its_address(
    environment: Mapping[str, str], command: str
) -> None:
    port = free_port()
    url = f"postgresql+psycopg://sea:secret@127.0.0.1:{port}/seamark"

    sentence = _sentence(_invoke(command, environment, url))

    assert f"PostgreSQL at 127.0.0.1:{port} does not answer" in sentence
    assert "secret" not in sentence


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"database": "nowhere"}, "has no database nowhere. Create it"),
        ({"username": "stranger"}, "refuses the user stranger or the password"),
    ],
)
def test_a_wrong_name_is_told_from_a_server_that_is_down(
    environment: Mapping[str, str], postgres_url: str, changes: dict[str, str], says: str
) -> None:
    url = make_url(postgres_url).set(**changes)  # type: ignore[arg-type]

    sentence = _sentence(_invoke("worker", environment, url.render_as_string(hide_password=False)))

    assert says in sentence


def test_a_file_that_cannot_be_opened_is_named(
    environment: Mapping[str, str], tmp_path: Path
) -> None:
    sentence = _sentence(_invoke("worker", environment, f"sqlite:///{tmp_path}/none/seamark.db"))

    assert f"The database file {tmp_path}/none/seamark.db cannot be opened" in sentence
