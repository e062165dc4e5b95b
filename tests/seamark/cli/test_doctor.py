"""`seamark doctor` names the part of a service that is broken, and ends in time whatever hangs."""

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner
from sqlalchemy import make_url, text

from seamark.cli import service_checks
from seamark.cli.findings import Check
from seamark.cli.main import cli
from seamark.server.database import schema
from seamark.server.database.engine import Database
from seamark.server.database.result_code import result_code
from seamark.server.settings import Settings
from seamark.server.storage import objects
from seamark.server.storage.objects import MARK
from tests.services import faulty_s3, s3, tables
from tests.services.faulty_s3 import Behaviour, FaultyS3
from tests.services.ports import free_port

MORE_THAN_ANY_DISK = 2**62


def _found(settings: Settings) -> Mapping[str, Check]:
    return {check.name: check for check in service_checks.of_service(settings)}


def _bad(settings: Settings) -> dict[str, str]:
    return {name: one.says for name, one in _found(settings).items() if one.state == "bad"}


@pytest.fixture
def service(settings: Settings) -> Settings:
    """A service in order, in its data folder."""
    settings = Settings.model_validate(settings.model_dump() | {"seed_key": "", "secret_key": ""})
    tables.create(settings).close()
    return settings


@pytest.fixture
def storage(s3_server: s3.Server) -> Iterator[FaultyS3]:
    with faulty_s3.in_front_of(s3_server.endpoint) as proxy:
        yield proxy


@pytest.fixture
def stored(service: Settings, s3_server: s3.Server, storage: FaultyS3, tmp_path: Path) -> Settings:
    """A service in order, in an object storage."""
    shared = s3_server.settings(tmp_path.name) | {"storage_endpoint": storage.endpoint}
    settings = service.model_copy(update=shared)
    there = objects.of(settings)
    assert there is not None
    there.put(MARK, (service.data / MARK).read_bytes())
    return settings


@pytest.mark.slow
def test_nothing_is_wrong_with_a_service_in_order(service: Settings, stored: Settings) -> None:
    assert (_bad(service), _bad(stored)) == ({}, {})


@pytest.mark.slow
@pytest.mark.parametrize(
    ("behaviour", "says"),
    [
        ("answers errors", "does not answer: "),
        ("refuses keys", "refuses the keys for the bucket seamark"),
        ("hangs", "gave no answer within 2 s"),
    ],
)
def test_an_object_storage_that_fails_is_named_in_time(
    stored: Settings, storage: FaultyS3, behaviour: Behaviour, says: str, monkeypatch: Any
) -> None:
    monkeypatch.setattr(service_checks, "ANSWER_S", 2.0 if behaviour == "hangs" else 60.0)
    storage.behave(behaviour)

    bad = _bad(stored)

    assert says in bad["object storage"]
    assert bad.keys() <= {"object storage", "database", "keys", "broker"}  # of a busy machine


@pytest.mark.slow
@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"storage_url": "s3://other-bucket/x"}, "there is no bucket other-bucket"),
        ({"storage_url": "s3://seamark/other"}, "is not the storage of this database"),
        ({"storage_endpoint": "http://127.0.0.1:1"}, "does not answer: "),
    ],
)
def test_a_wrong_place_of_the_objects_is_named(
    stored: Settings, changes: dict[str, str], says: str, monkeypatch: Any
) -> None:
    monkeypatch.setattr(service_checks, "ANSWER_S", 60.0)

    assert says in _bad(stored.model_copy(update=changes))["object storage"]


def test_the_data_folder_of_another_service_is_named(service: Settings) -> None:
    (service.data / MARK).write_text("of another one")

    assert "is not the data folder of this database" in _bad(service)["data folder"]


def test_other_seeds_and_another_result_code_are_named_apart(service: Settings) -> None:
    database = Database(service.database_url)
    with database.writing() as session:
        older = json.dumps(json.loads(result_code()) | {"numpy": "1.0"})
        session.execute(text("UPDATE data_folder SET result_code = :code"), {"code": older})
    database.close()

    bad = _bad(service.model_copy(update={"seed_key": "another one"}))

    assert bad.keys() == {"seed key", "result code"}
    assert "is not the key of this service" in bad["seed key"]
    assert "would not compute the results" in bad["result code"]


def test_a_lost_seed_key_is_named_and_no_other_one_is_drawn(service: Settings) -> None:
    (service.data / "seed_key").unlink()
    environ = {"SEAMARK_DATA": str(service.data), "SEAMARK_DATABASE_URL": service.database_url}

    bad = _bad(Settings.load(environ, looking=True))

    assert bad == {"seed key": "none on this machine"}
    assert not (service.data / "seed_key").exists()


def test_an_older_schema_is_named(service: Settings) -> None:
    schema.downgrade(service, "0031")

    assert "`seamark db upgrade`" in _bad(service)["database"]


def test_a_broker_that_is_down_is_named(service: Settings) -> None:
    away = service.model_copy(update={"broker_url": f"redis://127.0.0.1:{free_port()}"})

    assert "does not answer" in _bad(away)["broker"]


def test_the_free_space_is_measured_by_the_setting(service: Settings) -> None:
    full = service.model_copy(update={"free_min_bytes": MORE_THAN_ANY_DISK})
    low = service.model_copy(
        update={"free_min_bytes": int(0.6 * _free(service))}  # enough, but not twice
    )

    assert "GiB free" in _bad(full)["disk"]
    assert _found(low)["disk"].state == "warning"
    assert _found(service.model_copy(update={"free_min_bytes": 1}))["disk"].state == "ok"


def _free(settings: Settings) -> int:
    from seamark.server.storage import storage

    return storage.free_bytes(settings.data)


def test_files_that_others_may_read_are_a_warning_with_the_command_that_closes_them(
    service: Settings,
) -> None:
    (service.data / "seed_key").chmod(0o644)

    found = _found(service)["files of the service"]

    assert (found.state, "seed_key" in found.says) == ("warning", True)
    assert f"chmod go= {service.data}" in found.remedy


@pytest.mark.slow
def test_the_doctor_ends_with_3_when_runs_cannot_work_and_writes_nothing(tmp_path: Path) -> None:
    data = tmp_path / "data"
    environ = {"SEAMARK_BROKER_URL": f"redis://127.0.0.1:{free_port()}"}

    answer = CliRunner().invoke(cli, ["doctor", "--json", "--data", str(data)], env=environ)

    checks = {check["name"]: check for check in json.loads(answer.stdout)["checks"]}
    assert answer.exit_code == 3
    assert checks["broker"]["state"] == "bad"
    assert "does not answer" in checks["broker"]["says"]
    assert not data.exists()


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"database": "nowhere"}, "has no database nowhere"),
        ({"username": "locked", "password": "wrong"}, "refuses the user locked or the password"),
        ({"query": {"host": "/nowhere"}}, "does not answer"),
    ],
)
def test_a_database_that_is_down_a_wrong_password_and_an_unknown_name_are_told_apart(
    service: Settings, postgres_url: str, changes: dict[str, Any], says: str
) -> None:
    _require_password(postgres_url, user="locked")
    url = make_url(postgres_url).set(**changes).render_as_string(hide_password=False)

    bad = _bad(service.model_copy(update={"database_url": url}))

    assert says in bad["database"]
    assert "wrong" not in bad["database"]


def _require_password(url: str, *, user: str) -> None:
    """Have PostgreSQL ask a user for a password; all others need none."""
    rules = Path(str(make_url(url).query["host"])) / "data" / "pg_hba.conf"
    rule = f"local all {user} scram-sha-256\n"
    if not rules.read_text().startswith(rule):
        rules.write_text(rule + rules.read_text())
    database = Database(url)
    with database.writing() as session:
        session.execute(text(f"DROP ROLE IF EXISTS {user}"))
        session.execute(text(f"CREATE ROLE {user} LOGIN PASSWORD 'right'"))
        session.execute(text("SELECT pg_reload_conf()"))
    database.close()
