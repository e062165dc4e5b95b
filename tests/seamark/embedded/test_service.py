"""The embedded service for real: starts, evaluates, keeps its files to itself, leaves nothing."""

import os
import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from click.testing import CliRunner

from seamark.cli.main import cli
from seamark.client import Client
from seamark.server.accounts import accounts
from seamark.server.database import schema
from seamark.server.database.engine import Database
from seamark.server.settings import Settings
from tests.services.embedded import END_S, cancel_baselines, started, up

pytestmark = pytest.mark.slow

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
Service = tuple[str, "subprocess.Popen[str]"]  # its address and process


@pytest.fixture(scope="module", autouse=True)
def _usual_umask() -> Iterator[None]:
    """What a shell gives to what it starts, whatever that of the tests is."""
    before = os.umask(0o022)
    yield
    os.umask(before)


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of an earlier version, which anybody can read."""
    folder = tmp_path_factory.mktemp("service") / "data"
    folder.mkdir()
    schema.upgrade(Settings.model_validate({"data": folder}))
    for path in (folder, *folder.rglob("*")):
        path.chmod(0o755 if path.is_dir() else 0o644)
    (folder / "notes.txt").write_text("not of the service")
    return folder


@pytest.fixture(scope="module")
def database(data: Path) -> Iterator[Database]:
    opened = Database(f"sqlite:///{data}/seamark.db")
    yield opened
    opened.close()


@pytest.fixture(scope="module")
def service(data: Path, database: Database) -> Iterator[Service]:
    with started(data) as found:
        cancel_baselines(database)
        yield found


def _readable(folder: Path) -> list[str]:
    """Return what others can read or enter of what is in a folder."""
    found = list[str]()
    for place, folders, files in os.walk(folder):
        opened = [name for name in folders if (Path(place) / name).stat().st_mode & KNOWN]
        modes = {name: (Path(place) / name).lstat().st_mode for name in files}
        found += opened + [name for name, mode in modes.items() if mode & KNOWN]
        folders[:] = opened  # into the others nobody gets
    return found


def below(pid: int) -> set[int]:
    """Return all descendants of a process."""
    children = Path(f"/proc/{pid}/task/{pid}/children")
    found = {int(child) for child in children.read_text().split()} if children.exists() else set()
    return found.union(*(below(child) for child in found))


def alive(pid: int) -> bool:
    return Path(f"/proc/{pid}").exists()


@pytest.mark.host
def test_a_service_in_a_folder_that_all_can_read_hides_what_is_its_own_and_runs_uploads(
    data: Path, database: Database, service: Service, tmp_path: Path
) -> None:
    (tmp_path / "mine.py").write_text(PYTHON)
    (tmp_path / "mine.c").write_text(C)
    with database.writing() as session:
        ann = accounts.sign_up(session, "ann", None)
        token = accounts.new_token(session, ann.id, "t", ["read", "submit"], days=1.0)

    running = _readable(data)
    with Client(service[0], token=token) as client:
        ended = [
            client.submit("currents-v1", program=tmp_path / name, config=CONFIG, seed=1).wait()
            for name in ("mine.py", "mine.c")
        ]
    after = _readable(data)

    assert [(run.state, run.document["cause"]) for run in ended] == [("succeeded", None)] * 2
    assert (running, after) == (["notes.txt"], ["notes.txt"])


def test_up_evaluates_a_run_and_refuses_a_second_instance(data: Path, service: Service) -> None:
    with Client(service[0]) as client:
        ended = client.submit("currents-v1", controller="p", config=CONFIG, seed=7).wait()
        rows = ended.telemetry()
    second = subprocess.run(up(data), capture_output=True, text=True, check=False)

    assert ended.state == "succeeded"
    assert ended.digest
    assert len(rows) == 80  # 4 s at 20 Hz
    assert second.returncode == 2
    assert f"Seamark is already running on {data}" in second.stderr


def test_no_process_of_a_service_has_threads_of_numpy(service: Service) -> None:
    loaded = [pid for pid in {service[1].pid, *below(service[1].pid)} if _has_numpy(pid)]

    unlimited = [
        _about(pid, "cmdline")
        for pid in loaded
        if b"\nThreads:\t1\n" not in _about(pid, "status")
        and b"OPENBLAS_NUM_THREADS=1" not in _about(pid, "environ").split(b"\0")
    ]

    assert len(loaded) > 2  # `up`, the web server and a worker
    assert unlimited == []


def _has_numpy(pid: int) -> bool:
    return b"libscipy_openblas" in _about(pid, "maps")


def _about(pid: int, name: str) -> bytes:
    """Return what the kernel says about a process; nothing once it has ended."""
    try:
        return Path(f"/proc/{pid}/{name}").read_bytes()
    except (FileNotFoundError, ProcessLookupError):
        return b""


def test_the_end_of_a_service_leaves_no_process(service: Service) -> None:  # so it is the last
    process = service[1]
    children = below(process.pid)

    process.send_signal(signal.SIGTERM)
    process.communicate(timeout=END_S)

    assert len(children) > 4  # broker, web, worker and their children
    assert process.returncode == 0
    assert [pid for pid in children if alive(pid)] == []


def test_what_commands_write_is_for_their_owner_alone(tmp_path: Path) -> None:
    data, restored, archive = tmp_path / "data", tmp_path / "restored", tmp_path / "b.tar"
    for folder in (data, restored):
        folder.mkdir(mode=0o755)

    for words, place in (
        (("db", "upgrade"), data),
        (("user", "add", "ann", "--password", "correct horse"), data),
        (("backup", str(archive)), data),
        (("restore", str(archive)), restored),
    ):
        answer = CliRunner().invoke(cli, [*words, "--data", str(place)])
        assert answer.exit_code == 0, answer.output

    assert (_readable(data), _readable(restored)) == ([], [])
    assert not archive.stat().st_mode & KNOWN
