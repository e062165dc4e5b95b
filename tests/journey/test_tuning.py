"""`seamark tune --server` against the service."""

import json
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner
from sqlalchemy import select

from seamark.cli.main import cli
from seamark.server.accounts import accounts
from seamark.server.database.engine import Database
from seamark.server.database.tables import Run
from seamark.server.runs.record.states import LIVE
from tests.journey.service import Service

pytestmark = [pytest.mark.host, pytest.mark.slow]

SHORT = ("--set", "levels=0.2", "--set", "level_duration_s=3", "--set", "settle_s=1")
LONG = ("--set", "levels=0.2", "--set", "level_duration_s=600")
SEARCH = ("--method", "grid", "--batch", "3", "--json")
BRITTLE = """
PARAMETERS = {"gain": {"default": 0.1, "range": [0.0, 2.0]}}


class Controller:
    def __init__(self, config):
        self.gain = config["gain"]

    def reset(self, level):
        pass

    def step(self, observation):
        if self.gain > 1.0:
            raise ValueError("too much")
        return [self.gain * observation.error[0], self.gain * observation.error[1], 0.0, 0.0]
"""


@dataclass(frozen=True)
class Account:
    """An account of the service and its runs."""

    name: str
    options: tuple[str, ...]
    database: Database

    def states(self) -> list[str]:
        with self.database.reading() as session:
            return list(session.scalars(select(Run.state).where(Run.owner == self.name)))


@pytest.fixture
def account(service: Service, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Account]:
    monkeypatch.chdir(tmp_path)
    with closing(Database(f"sqlite:///{service.data / 'seamark.db'}")) as database:
        with database.writing() as session:
            user = accounts.sign_up(session, f"tuner-{time.monotonic_ns()}", None)
            token = accounts.new_token(session, user.id, "t", ("read", "submit"), days=1.0)
            owner = f"user:{user.id}"
        yield Account(owner, ("--server", service.url, "--token", token), database)


def _tune(*arguments: str) -> dict[str, Any]:
    done = CliRunner().invoke(cli, ["tune", "currents-v1", *arguments])
    assert done.exit_code == 0, done.output
    found: dict[str, Any] = json.loads(done.stdout)
    return found


def test_a_server_gives_the_candidates_the_scores_that_they_have_here(account: Account) -> None:
    Path("brittle.py").write_text(BRITTLE)
    options = ("--controller", "brittle.py", *SHORT, *SEARCH, "--trials", "1")
    count = ("--param", "gain=0.8,2", "--candidates", "2", "--validate", "2")

    there = _tune(*options, *count, *account.options)
    Path("tuned.csv").rename("there.csv")
    here = _tune(*options, *count)

    assert (there.pop("server"), here.pop("server")) == (account.options[1], None)
    assert there == here
    assert [each["score"] is None for each in here["candidates"]] == [False, False, True]
    assert here["validation"]["low"] is not None
    assert Path("there.csv").read_text() == Path("tuned.csv").read_text()
    assert len(account.states()) == 5


def test_ctrl_c_cancels_the_runs_on_the_server_and_keeps_the_results(account: Account) -> None:
    options = ("--controller", "pi", "--param", "kp=0.1:2", *LONG, *SEARCH, *account.options)
    process = subprocess.Popen(
        [sys.executable, "-m", "seamark.cli.main", "tune", "currents-v1", *options],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    deadline = time.monotonic() + 120.0
    while len(account.states()) < 3:
        assert process.poll() is None, process.communicate()[1]
        assert time.monotonic() < deadline
        time.sleep(0.05)

    process.send_signal(signal.SIGINT)
    process.communicate(timeout=120.0)

    assert process.returncode == 130
    assert [state for state in account.states() if state in LIVE] == []
    assert Path("tuned.csv").read_text().splitlines()[1] == "candidate,score,failure,kp"
