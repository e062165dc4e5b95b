"""The embedded service for real: starts, evaluates, ends, leaves nothing behind."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from seamark.client import Client
from tests.services.embedded import address_of

COMMAND = [
    sys.executable,
    "-m",
    "seamark.cli.main",
    "up",
    "--port",
    "0",
    "--json",
    "--workers",
    "1",
]


@pytest.fixture
def service(tmp_path: Path) -> Iterator["subprocess.Popen[str]"]:
    """`seamark up` in a folder of its own; ended at the latest with the test."""
    environ = {k: v for k, v in os.environ.items() if not k.startswith("SEAMARK_")}
    # Otherwise the built-in entries of the leaderboard would keep the only worker busy first.
    environ |= {"SEAMARK_RANKED_TRIALS": "1"}
    started = subprocess.Popen(
        [*COMMAND, "--data", str(tmp_path / "data")],
        env=environ,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    yield started
    started.terminate()
    started.communicate(timeout=60)


def below(pid: int) -> set[int]:
    """Return all descendants of a process."""
    children = Path(f"/proc/{pid}/task/{pid}/children")
    found = {int(child) for child in children.read_text().split()} if children.exists() else set()
    return found.union(*(below(child) for child in found))


def alive(pid: int) -> bool:
    return Path(f"/proc/{pid}").exists()


@pytest.mark.slow
def test_up_evaluates_a_run_refuses_a_second_instance_and_leaves_no_process(
    service: "subprocess.Popen[str]", tmp_path: Path
) -> None:
    config = {"levels": [0.0], "level_duration_s": 40.0}
    with Client(address_of(service)) as client:
        ordered = client.submit("currents-v1", controller="p", config=config, seed=7)
        ended = client.wait(ordered["id"])
    second = subprocess.run(
        [*COMMAND, "--data", str(tmp_path / "data")], capture_output=True, text=True, check=False
    )
    started = below(service.pid)
    service.send_signal(signal.SIGTERM)
    service.communicate(timeout=60)

    assert ended["state"] == "succeeded"
    assert ended["result"]["digest"]
    assert second.returncode == 2
    assert f"Seamark is already running on {tmp_path / 'data'}" in second.stderr
    assert len(started) > 4  # broker, web, worker and their children
    assert service.returncode == 0
    assert [pid for pid in started if alive(pid)] == []
