"""The Compose files: what can be checked without an engine."""

import json
import re
import shlex
import subprocess
from functools import cache
from importlib.metadata import distribution
from pathlib import Path
from typing import Any

import jsonschema_rs
import pytest

from seamark.cli.main import cli
from seamark.server.settings import Settings
from tests.services import compose
from tests.services.commands import parse

FILES = ("compose.yaml", "compose.machines.yaml", "compose.worker.yaml")
STORES = ("redis", "postgres", "objects")
WORKERS = [("worker", "compose.yaml"), ("worker", "compose.worker.yaml")]
HOSTING = (compose.ROOT / "docs" / "hosting.md").read_text("utf-8")
SCRIPT = compose.ROOT / "deploy" / "secrets.sh"
_CASES: list[tuple[str, str]] = [
    (name, file)
    for file in ("compose.yaml", "compose.worker.yaml")
    for name in compose.read(file)["services"]
]
_OWN = [case for case in _CASES if case[0] not in STORES]


def _is_step(service: dict[str, Any]) -> bool:
    return bool(service.get("restart") == "no")


@cache
def schema() -> jsonschema_rs.Draft7Validator:
    # Not by importlib.resources, which imports the package, for half a second.
    path = "check_jsonschema/builtin_schemas/vendor/compose-spec.json"
    text = Path(str(distribution("check-jsonschema").locate_file(path))).read_text("utf-8")
    return jsonschema_rs.Draft7Validator(json.loads(text))


@pytest.fixture(scope="module")
def secrets(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of secrets that the script makes."""
    folder = tmp_path_factory.mktemp("host")
    subprocess.run(["sh", str(SCRIPT)], cwd=folder, check=True)
    return folder / "secrets"


@pytest.mark.parametrize("file", FILES)
def test_a_file_has_the_schema_of_compose(file: str) -> None:
    schema().validate(compose.read(file))


@pytest.mark.parametrize(("name", "file"), _OWN)
def test_the_settings_of_a_service_exist(name: str, file: str, secrets: Path) -> None:
    given = compose.service(name, file)
    variables = compose.environment(given["environment"], {"PRIVATE_ADDRESS": "10.0.0.1"})
    readable = {
        name: text.replace("/run/secrets", str(secrets)) for name, text in variables.items()
    }

    settings = Settings.load(readable | {"SEAMARK_DATA": str(secrets.parent / "data")})

    assert settings.public
    assert settings.storage_url == "s3://seamark"
    assert {text.rsplit("/", 1)[1] for text in variables.values() if "/run/secrets/" in text} == (
        set(given["secrets"])
    )


@pytest.mark.parametrize(("name", "file"), _OWN)
def test_the_command_of_a_service_exists(name: str, file: str) -> None:
    given = compose.service(name, file)
    commands = [given["command"]]
    commands += [
        words[1:] for words in [given["healthcheck"].get("test", [])] if "seamark" in words
    ]

    for program, *words in commands:
        assert program == "seamark"
        parse(cli, words)


@pytest.mark.parametrize(("name", "file"), _CASES)
def test_a_service_has_limits_a_health_check_and_no_right_that_it_does_not_need(
    name: str, file: str
) -> None:
    given = compose.service(name, file)
    limits = given["deploy"]["resources"]["limits"]

    assert given["cap_drop"] == ["ALL"]
    assert "no-new-privileges:true" in given["security_opt"]
    assert given["read_only"]
    assert given["user"]
    assert {"cpus", "memory", "pids"} == set(limits)
    assert given["logging"]["options"]["max-size"]
    assert _is_step(given) == given["healthcheck"].get("disable", False)
    assert _is_step(given) or given["healthcheck"]["interval"]


def test_only_the_worker_and_a_store_without_capabilities_are_root() -> None:
    root = {name for name, file in _CASES if compose.service(name, file)["user"] == "0:0"}
    added = {name: compose.service(name, file).get("cap_add") for name, file in _CASES}

    assert root == {"worker", "objects"}
    assert {name for name, capabilities in added.items() if capabilities} == {"worker"}
    assert added["worker"] == ["SETUID", "SETGID", "KILL"]


@pytest.mark.parametrize(("name", "file"), WORKERS)
def test_a_worker_has_neither_the_session_secret_nor_the_rights_of_the_owner(
    name: str, file: str, secrets: Path
) -> None:
    given = compose.service(name, file)
    url = (secrets / "worker_database_url").read_text()

    assert not {"secret_key", "database_url", "postgres_password"} & set(given["secrets"])
    assert url.startswith("postgresql://seamark_worker:")
    assert not given.get("ports")


def test_both_descriptions_of_a_worker_say_the_same() -> None:
    here, elsewhere = (compose.service(*each) for each in WORKERS)
    del here["depends_on"], here["networks"], here["deploy"]["replicas"], elsewhere["extra_hosts"]

    assert here == elsewhere


def test_what_runs_programs_has_no_way_out() -> None:
    networks = compose.read()["networks"]

    assert compose.service("worker")["networks"] == ["inside"]
    assert networks["inside"] == {"internal": True}


def test_the_reference_entries_are_queued_before_anybody_looks() -> None:
    services = compose.read()["services"]
    steps = [" ".join(each["command"]) for each in services.values() if _is_step(each)]

    assert "seamark db upgrade" in steps
    assert "seamark db grant-worker seamark_worker" in steps
    assert "seamark db reference-entries" in steps


def test_every_secret_is_made_by_the_script_and_readable_to_any_user_of_a_container(
    secrets: Path,
) -> None:
    wanted = {name for file in FILES for name in compose.read(file).get("secrets", {})}
    made = {path.name: path for path in secrets.iterdir()}

    assert wanted | {"objects.env"} == set(made)
    assert secrets.stat().st_mode & 0o077 == 0
    assert all(path.stat().st_mode & 0o777 == 0o644 and path.read_text() for path in made.values())


def test_a_second_call_of_the_script_changes_no_secret(secrets: Path) -> None:
    before = {path.name: path.read_text() for path in secrets.iterdir()}

    subprocess.run(["sh", str(SCRIPT)], cwd=secrets.parent, check=True)

    assert {path.name: path.read_text() for path in secrets.iterdir()} == before


def test_the_broker_needs_a_password_that_no_argument_shows(secrets: Path) -> None:
    words = compose.command(compose.service("redis")["command"], {})
    password = (secrets / "broker_password").read_text()

    assert "requirepass" in words[-1]
    assert shlex.split(words[-1])
    assert password not in " ".join(words)
    assert password in (secrets / "broker_url").read_text()


@pytest.mark.parametrize("file", FILES)
def test_the_files_are_in_the_documentation_for_operators(file: str) -> None:
    assert file in HOSTING
    assert "deploy/secrets.sh" in HOSTING


def test_every_image_has_a_version() -> None:
    images = {service["image"] for service in compose.read()["services"].values()}
    others = {image for image in images if not image.startswith("seamark-")}

    assert len(others) == len(STORES)
    assert [image for image in others if not re.search(r":v?\d+(\.\d+)*(-\w+)?$", image)] == []


@pytest.mark.parametrize(
    ("file", "services"),
    [("compose.mail.yaml", {"web", "caretaker"}), ("compose.oidc.yaml", {"web"})],
)
def test_mail_and_single_sign_on_are_files_of_their_own_with_settings_that_exist(
    file: str, services: set[str], tmp_path: Path
) -> None:
    values = {"SEAMARK_URL": "https://s.example", "SEAMARK_MAIL_FROM": "a@s.example"}
    values |= {"SEAMARK_OIDC_ISSUER": "https://id.example"}
    added = compose.read(file)
    for name in added["secrets"]:
        (tmp_path / name).write_text("smtp://user:word@mail.example:587")

    schema().validate(added)
    for name in services:
        given = compose.environment(compose.service(name, file)["environment"], values)
        paths = {key: text.replace("/run/secrets", str(tmp_path)) for key, text in given.items()}
        settings = Settings.load(paths | {"SEAMARK_DATA": str(tmp_path / "data")})
        assert settings.mail_url or settings.oidc_issuer

    assert set(added["services"]) == services
    assert set(added["secrets"]) <= {
        each for name in services for each in compose.service(name, file)["secrets"]
    }
    assert f"`{file}`" in HOSTING
