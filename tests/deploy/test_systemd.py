"""The files for one host without Docker, where there is no systemd to read them."""

import re
import shlex
import shutil
import subprocess
import sys
from collections import defaultdict
from pathlib import Path

import pytest

from seamark.cli.main import cli
from seamark.server.settings import SIGNS_NOTHING, Settings
from tests.services import compose
from tests.services.commands import parse

FOLDER = compose.ROOT / "deploy" / "systemd"
UNITS = sorted(path.name for path in FOLDER.glob("seamark-*"))
HOSTING = (compose.ROOT / "docs" / "hosting.md").read_text("utf-8")
# With any of these no box starts, or its limits are weaker (docs/hosting.md).
DENIED_TO_BOXES = {
    "ProtectControlGroups",
    "RestrictNamespaces",
    "ProtectKernelTunables",
    "ProtectHostname",
}


@pytest.fixture(scope="module")
def secrets(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of secrets that the recipe makes."""
    folder = tmp_path_factory.mktemp("etc")
    environment = {
        "DATABASE_HOST": "127.0.0.1",
        "BROKER_HOST": "127.0.0.1",
        "PATH": "/usr/bin:/bin",
    }
    script = str(compose.ROOT / "deploy" / "secrets.sh")
    subprocess.run(["sh", script], cwd=folder, env=environment, check=True)
    return folder / "secrets"


def options(unit: str) -> dict[str, list[str]]:
    """Return the options of a unit, each with all of its values."""
    found = defaultdict[str, list[str]](list)
    for line in (FOLDER / unit).read_text().splitlines():
        if line and line[0] not in "#[":
            name, _, value = line.partition("=")
            found[name].append(value)
    return found


def variables(name: str, secrets: Path) -> dict[str, str]:
    """Return the environment that a file gives, with the secrets of a test."""
    lines = (FOLDER / name).read_text().splitlines()
    given = dict(line.split("=", 1) for line in lines if line and not line.startswith("#"))
    return {key: text.replace("/etc/seamark/secrets", str(secrets)) for key, text in given.items()}


@pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="systemd is not installed")
def test_systemd_has_nothing_to_say_about_the_units(tmp_path: Path) -> None:
    for unit in UNITS:
        text = (
            (FOLDER / unit)
            .read_text()
            .replace("/opt/seamark/bin", str(Path(sys.executable).parent))
        )
        (tmp_path / unit).write_text(text)

    command = ["systemd-analyze", "verify", "--man=no", *map(str, tmp_path.iterdir())]
    said = subprocess.run(command, capture_output=True, text=True, check=False)

    assert [line for line in said.stderr.splitlines() if "seamark-" in line] == []


@pytest.mark.parametrize("unit", [unit for unit in UNITS if unit.endswith(".service")])
def test_the_command_of_a_unit_exists(unit: str) -> None:
    (line,) = options(unit)["ExecStart"]
    program, *words = shlex.split(line)

    assert program == "/opt/seamark/bin/seamark"
    parse(cli, words)


@pytest.mark.parametrize("unit", [unit for unit in UNITS if unit.endswith(".service")])
def test_a_unit_has_its_settings_from_a_file_of_the_recipe(unit: str) -> None:
    (file,) = options(unit)["EnvironmentFile"]

    assert (FOLDER / Path(file).name).is_file()


def test_the_settings_exist_and_those_of_the_worker_have_no_key_and_no_right_of_the_owner(
    secrets: Path, tmp_path: Path
) -> None:
    own = {"SEAMARK_DATA": str(tmp_path)}
    web = Settings.load(variables("environment", secrets) | own)
    given = variables("worker", secrets) | own
    worker = Settings.load(given | {"SEAMARK_SECRET_KEY": SIGNS_NOTHING})

    assert web.public
    assert worker.public
    assert web.derives_seeds
    assert not worker.derives_seeds
    assert {name for name in given if "KEY" in name} == set()
    assert re.match(r"postgresql://seamark:\w+@127\.0\.0\.1/seamark$", web.database_url)
    assert re.match(r"postgresql://seamark_worker:\w+@127\.0\.0\.1/seamark$", worker.database_url)
    assert re.match(r"redis://:\w+@127\.0\.0\.1:6379/0$", worker.broker_url)
    assert list(tmp_path.iterdir()) == []


def test_boxes_start_in_the_unit_of_the_worker_and_in_no_other() -> None:
    assert DENIED_TO_BOXES.isdisjoint(options("seamark-worker.service"))
    for unit in ("seamark-web.service", "seamark-caretaker.service"):
        assert set(options(unit)) >= DENIED_TO_BOXES


@pytest.mark.parametrize("file", sorted(path.name for path in FOLDER.iterdir()))
def test_a_file_is_in_the_recipe(file: str) -> None:
    recipe = HOSTING.partition("\n## One Debian host without Docker\n")[2].partition("\n## ")[0]

    assert f"deploy/systemd/{file} " in recipe or f"`{file}`" in recipe


def test_the_command_of_an_operator_is_a_script() -> None:
    subprocess.run(["sh", "-n", str(FOLDER / "seamark")], check=True)
