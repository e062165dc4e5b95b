"""Every command has --json, and then prints one JSON document or JSON lines, and nothing else."""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import click
import pytest
from click.testing import CliRunner

from seamark.cli.main import cli
from seamark.server.settings import Settings
from seamark.sim.vehicles import load
from seamark.sim.vehicles.urdf import urdf_of
from tests.cast import Backend
from tests.seamark.competitions.audits import document

SHORT = ("--set", "levels=0", "--set", "level_duration_s=2", "--set", "settle_s=1", "--seed", "7")
CASES = {  # command -> arguments; {first} and {second} are finished runs
    "init": "mine",
    "check": "wrong.py",
    "submit": "currents-v1 --controller pi",
    "submit --sweep": "currents-v1 --controller pi --sweep kp=0.1,0.2",
    "compare": "{first} {second}",
    "leaderboard": "currents-v1",
    "dataset": f"currents-v1 {' '.join(SHORT)} --every 20",
    "demonstrations": "valve-v1 --episodes 1 --jobs 1 --set levels=0 --set level_duration_s=2",
    "benchmarks": "",
    "benchmarks NAME": "currents-v1",
    "vehicle check": "girona500",
    "vehicle import": "hull.urdf -o hull.toml",
    "completion": "bash",
    "competition audit": "audit.json",
    "competition init": "cup.toml",
    "competition check": "cup.toml",
    "user add": "zoe",
    "user import": "names.txt",
    "user invite": "--count 2",
    "user list": "",
    "user role": "ben teacher",
    "user reset": "ben",
    "user delete": "ben --yes",
    "user password": "eva",
    "token new": "ann",
    "audit": "",
    "backup": "b.tar",
    "restore": "b.tar --check",
    "db upgrade": "",
    "db rebuild-leaderboard": "",
    "db downgrade": "0031",
}
PROCESSES = ("web", "worker")  # they run until they are stopped
ELSEWHERE = frozenset(
    {
        *("run", "rerun", "replay", "export", "plot", "tune", "up", "doctor"),
        *("db reference-entries", "db grant-worker", "mail test"),
        *("competition create", "competition open", "competition move"),
        *("competition show", "competition join"),
        *("bridge rosbridge", "bridge ardusub", "current", "identify", "track"),
    }
)  # they take long, log or need a server, and have tests that read their JSON


def _commands(group: click.Group, *names: str) -> Iterator[tuple[str, click.Command]]:
    context = click.Context(group)
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        assert command is not None
        if isinstance(command, click.Group):
            yield from _commands(command, *names, name)
        else:
            yield " ".join((*names, name)), command


COMMANDS = dict(_commands(cli))


def _without_option(case: str) -> str:
    return " ".join(word for word in case.split() if word.islower() and not word.startswith("-"))


@pytest.fixture
def folder(
    backend: Backend, address: str, token: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Path:
    """A folder from which commands reach a service with the cast."""
    (tmp_path / "wrong.py").write_text("class Controler:\n    pass\n")
    (tmp_path / "audit.json").write_text(json.dumps(document()))
    (tmp_path / "names.txt").write_text("tim\nann\n")
    (tmp_path / "hull.urdf").write_text(urdf_of(load("girona500")))
    monkeypatch.chdir(tmp_path)
    for variable, value in backend.settings.environment().items():
        monkeypatch.setenv(variable, value)
    monkeypatch.setenv("SEAMARK_SERVER", address)
    monkeypatch.setenv("SEAMARK_TOKEN", token)
    return tmp_path


def _is_json(text: str) -> bool:
    """Tell whether a text is one document, or has one in each line."""
    for documents in ([text], text.splitlines()):
        with suppress(json.JSONDecodeError):
            return bool(documents) and all(
                isinstance(json.loads(each), dict | list) for each in documents
            )
    return False


def test_every_command_is_tried_with_json() -> None:
    assert {_without_option(case) for case in CASES} | {*PROCESSES, *ELSEWHERE} == set(COMMANDS)


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_has_the_option(name: str) -> None:
    assert "--json" in {option for given in COMMANDS[name].params for option in given.opts}


@pytest.mark.slow
@pytest.mark.usefixtures("folder")
def test_commands_print_nothing_but_json(backend: Backend) -> None:
    runs = {"first": backend.succeeded(seed=7), "second": backend.succeeded(seed=7)}

    printed: dict[str, str] = {}
    for case, arguments in CASES.items():
        words = [*_without_option(case).split(), *arguments.format(**runs).split()]
        printed[case] = CliRunner().invoke(cli, [*words, "--json"]).stdout

    assert {case: text for case, text in printed.items() if not _is_json(text)} == {}


@pytest.mark.slow
@pytest.mark.parametrize("name", PROCESSES)
def test_a_process_of_a_service_prints_where_it_runs_and_logs_elsewhere(
    name: str, backend: Backend, settings: Settings
) -> None:
    environ = {key: text for key, text in os.environ.items() if not key.startswith("SEAMARK_")}
    environ |= settings.environment() | {"SEAMARK_PORT": "0"}
    command = [sys.executable, "-m", "seamark.cli.main", name, "--json"]
    with subprocess.Popen(
        command, env=environ, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    ) as process:
        assert process.stdout is not None
        first = "".join(iter(process.stdout.readline, "}\n")) + "}"
        process.send_signal(signal.SIGTERM)
        rest = process.stdout.read()

    assert json.loads(first)["data"] == str(settings.data)
    assert rest == ""
