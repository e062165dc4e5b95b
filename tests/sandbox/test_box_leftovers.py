"""Nothing of a box is left: after runs that end well or badly, and after killed workers."""

import contextlib
import json
import os
import select
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from seamark.sandbox.box import Box
from seamark.sandbox.isolation import cgroup_parents
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.limits import Limits
from seamark.sandbox.outcome import ProgramEnded
from tests.sandbox.conftest import descriptors, printed, program

pytestmark = pytest.mark.host


@pytest.mark.slow
def test_nothing_is_left_after_twenty_runs(isolation) -> None:
    before, threads = descriptors(), set(threading.enumerate())
    everybody = []
    for _ in range(20):
        with Box(limits=Limits(), isolation=isolation) as box:
            box.wait_ready()
            everybody += [os.pidfd_open(pid) for pid in box.processes()]
            with contextlib.suppress(ProgramEnded):  # when both answer in time
                printed(box, b"import os\n" + program(init="os.fork()"))
    ended = [bool(select.select([descriptor], [], [], 5.0)[0]) for descriptor in everybody]
    for descriptor in everybody:
        os.close(descriptor)

    assert len(ended) >= 40
    assert all(ended)
    assert not descriptors() - before
    assert not set(threading.enumerate()) - threads
    # Unlike `glob`, `walk` does not mind that groups of others vanish meanwhile.
    groups = [Path(folder).name for folder, *_ in os.walk("/sys/fs/cgroup")]
    assert not [name for name in groups if name.startswith(f"seamark-box-{os.getpid()}-")]


WORKER = """
import json, signal, sys
from seamark.sandbox.box import Box
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.limits import Limits

box = Box(limits=Limits(), isolation=IsolationLevel(int(sys.argv[1])))
if sys.argv[2] == "ready":
    box.wait_ready()
print(json.dumps(box.processes()), flush=True)
signal.pause()
"""


def killed_worker(isolation: IsolationLevel, when: str) -> tuple[int, list[int]]:
    """Kill a process that has a box; return its pid and descriptors of the box's processes."""
    command = [sys.executable, "-c", WORKER, str(int(isolation)), when]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as worker:
        assert worker.stdout is not None
        descriptors = [os.pidfd_open(pid) for pid in json.loads(worker.stdout.readline())]
        worker.kill()
    return worker.pid, descriptors


def test_a_box_dies_with_its_worker(isolation) -> None:
    _, descriptors = killed_worker(isolation, "ready")

    assert descriptors
    for descriptor in descriptors:
        assert select.select([descriptor], [], [], 5.0)[0]
        os.close(descriptor)


def test_what_a_worker_killed_at_the_start_of_a_box_leaves_is_removed_by_the_next_box(
    isolation,
) -> None:
    if isolation is not IsolationLevel.STRONG:
        pytest.skip("needs control groups")
    pids = [killed_worker(isolation, "at once")[0] for _ in range(3)]

    for _ in range(2):  # a killed process may need a moment: then its group goes with the second
        with Box(limits=Limits(), isolation=isolation) as box:
            printed(box, program())

    for folder in cgroup_parents.parent_groups().folders():
        assert not [pid for pid in pids if list(folder.glob(f"seamark-box-{pid}-*"))]
