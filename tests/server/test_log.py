"""The log of the service."""

import subprocess
import sys
from pathlib import Path

import pytest

FULL = Path("/dev/full")  # every write fails as on a full disk
LOGS = """
import structlog
from seamark.server import log

log.configure()
for number in range(2000):
    structlog.get_logger().error("event", number=number)
print("went on")
"""


@pytest.mark.skipif(not FULL.exists(), reason="the system has no /dev/full")
def test_a_log_on_a_full_disk_stops_nobody_who_logs() -> None:
    with FULL.open("wb") as full:
        command = [sys.executable, "-c", LOGS]
        found = subprocess.run(command, stdout=subprocess.PIPE, stderr=full, check=False)

    assert found.stdout == b"went on\n"
