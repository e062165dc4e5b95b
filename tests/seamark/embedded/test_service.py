"""The embedded service for real: starts, evaluates, ends, leaves nothing behind."""

import signal
import subprocess
from pathlib import Path

import pytest

from seamark.client import Client
from tests.services.embedded import END_S, started, up


def below(pid: int) -> set[int]:
    """Return all descendants of a process."""
    children = Path(f"/proc/{pid}/task/{pid}/children")
    found = {int(child) for child in children.read_text().split()} if children.exists() else set()
    return found.union(*(below(child) for child in found))


def alive(pid: int) -> bool:
    return Path(f"/proc/{pid}").exists()


@pytest.mark.slow
def test_up_evaluates_a_run_refuses_a_second_instance_and_leaves_no_process(
    tmp_path: Path,
) -> None:
    data, config = tmp_path / "data", {"levels": [0.0], "level_duration_s": 40.0}
    with started(data) as (address, service):
        with Client(address) as client:
            ended = client.submit("currents-v1", controller="p", config=config, seed=7).wait()
            rows = ended.telemetry()
        second = subprocess.run(up(data), capture_output=True, text=True, check=False)
        children = below(service.pid)
        service.send_signal(signal.SIGTERM)
        service.communicate(timeout=END_S)

    assert ended.state == "succeeded"
    assert ended.digest
    assert len(rows) == 800  # 40 s at 20 Hz
    assert second.returncode == 2
    assert f"Seamark is already running on {data}" in second.stderr
    assert len(children) > 4  # broker, web, worker and their children
    assert service.returncode == 0
    assert [pid for pid in children if alive(pid)] == []
