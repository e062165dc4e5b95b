"""What a service writes is for its owner alone, and its boxes find what they need all the same."""

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from seamark.client import Client
from seamark.server.database import schema
from seamark.server.database.engine import Database
from seamark.server.settings import Settings
from tests.services.embedded import cancel_baselines, started

PYTHON = """
import numpy, scipy.signal
class Controller:
    def __init__(self, config): pass
    def step(self, observation): return numpy.zeros(4)
"""
C = """
#include "seamark.h"
int seamark_step(const seamark_observation *observation, seamark_command *command) {
    (void)observation, (void)command;
    return 0;
}
"""
CONFIG = {"levels": [0.0], "level_duration_s": 4.0, "settle_s": 1.0}
KNOWN = 0o077  # of others, and of the group


@pytest.fixture(autouse=True)
def _usual_umask() -> Iterator[None]:
    """What a shell gives to what it starts, whatever that of the tests is."""
    before = os.umask(0o022)
    yield
    os.umask(before)


@pytest.fixture
def data(tmp_path: Path) -> Path:
    """A folder of an earlier version, which anybody can read."""
    folder = tmp_path / "data"
    folder.mkdir(mode=0o755)
    schema.upgrade(Settings.model_validate({"data": folder}))
    for path in (folder, *folder.rglob("*")):
        path.chmod(0o755 if path.is_dir() else 0o644)
    return folder


def _seamark(*words: str) -> str:
    command = [sys.executable, "-m", "seamark.cli.main", *words]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def _readable(folder: Path) -> list[str]:
    """Return what others can read or enter of what is in a folder."""
    found = list[str]()
    for place, folders, files in os.walk(folder):
        opened = [name for name in folders if (Path(place) / name).stat().st_mode & KNOWN]
        modes = {name: (Path(place) / name).lstat().st_mode for name in files}
        found += opened + [name for name, mode in modes.items() if mode & KNOWN]
        folders[:] = opened  # into the others nobody gets
    return found


@pytest.mark.slow
@pytest.mark.host
def test_a_service_in_a_folder_that_all_can_read_hides_what_is_its_own_and_runs_uploads(
    data: Path, tmp_path: Path
) -> None:
    (tmp_path / "mine.py").write_text(PYTHON)
    (tmp_path / "mine.c").write_text(C)
    (data / "notes.txt").write_text("not of the service")
    place = ("--data", str(data))

    with started(data) as (address, _):
        cancel_baselines(Database(f"sqlite:///{data}/seamark.db"))
        running = _readable(data)
        _seamark("user", "add", "ann", "--password", "correct horse", *place)
        token = _seamark("token", "new", "ann", *place).split()[-1]
        with Client(address, token=token) as client:
            ended = [
                client.submit("currents-v1", program=tmp_path / name, config=CONFIG, seed=1).wait()
                for name in ("mine.py", "mine.c")
            ]
        after = _readable(data)

    assert [(run.state, run.document["cause"]) for run in ended] == [("succeeded", None)] * 2
    assert (running, after) == (["notes.txt"], ["notes.txt"])


@pytest.mark.slow
def test_what_commands_write_is_for_their_owner_alone(tmp_path: Path) -> None:
    data, restored = tmp_path / "data", tmp_path / "restored"
    for folder in (data, restored):
        folder.mkdir(mode=0o755)

    _seamark("db", "upgrade", "--data", str(data))
    _seamark("user", "add", "ann", "--password", "correct horse", "--data", str(data))
    _seamark("backup", str(tmp_path / "b.tar"), "--data", str(data))
    _seamark("restore", str(tmp_path / "b.tar"), "--data", str(restored))

    assert (_readable(data), _readable(restored)) == ([], [])
    assert not (tmp_path / "b.tar").stat().st_mode & KNOWN
