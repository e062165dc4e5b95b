"""The supervisor in a process of its own: it would end all children of the tests."""

import subprocess
import sys
from pathlib import Path

import pytest

RETIRING = """
import sys, time
from pathlib import Path
from seamark.embedded.supervisor import Child, Supervisor

said, pids = [], Path(sys.argv[1], "pids")
child = "import os, time; open({!r}, 'a').write(f'{{os.getpid()}}\\\\n'); time.sleep(600)"
argv = [sys.executable, "-c", child.format(str(pids))]

def started(supervisor, count):
    while not pids.exists() or len(pids.read_text().split()) < count:
        supervisor.wait(0.05)

with Supervisor(said.append) as supervisor:
    log = Path(sys.argv[1], "log")
    supervisor.add(Child("worker", argv, {}, log))
    started(supervisor, 1)
    old, new = supervisor.children[0], supervisor.add(Child("worker", argv, {}, log))
    started(supervisor, 2)
    supervisor.retire(old)
    while old in supervisor.children:
        supervisor.wait(0.1)
    print(supervisor.children == [new], new.process.poll(), old.exits, said)
"""


# What is opened and listed while nothing happens is told by the interpreter's own audit events.
IDLE = """
import sys
from pathlib import Path
from seamark.embedded.supervisor import Child, Supervisor

looked_at = []
sys.addaudithook(lambda event, args: looked_at.append(str(args[0])) if watching else None)
watching = False
argv = [sys.executable, "-c", "import time; time.sleep(600)"]

with Supervisor(print) as supervisor:
    for name in ("broker", "web", "worker"):
        supervisor.add(Child(name, argv, {}, Path(sys.argv[1], "log")))
    watching = True
    for _ in range(10):
        supervisor.wait(0.02)
    watching = False
    print([path for path in looked_at if path.startswith("/proc")])
"""
# Its child's child becomes an orphan, which a dead one would be for ever unless somebody reaps it.
ORPHAN = """
import os, sys, time
from pathlib import Path
from seamark.embedded.supervisor import Child, Supervisor

file = Path(sys.argv[1], "pid")
script = f"(setsid sleep 0.1 & echo $! > {file}.new; mv {file}.new {file}); sleep 600"
with Supervisor(print) as supervisor:
    child = supervisor.add(Child("worker", ["sh", "-c", script], {}, Path(sys.argv[1], "log")))
    until = time.monotonic() + 60.0
    while not file.exists() or os.path.exists(f"/proc/{int(file.read_text())}"):
        assert time.monotonic() < until
        supervisor.wait(0.05)
    print(child.process.poll(), child.exits)
"""
# The second one ends the wait of a minute and more.
RESTARTED = """
import signal, sys
from pathlib import Path
from seamark.embedded.supervisor import Child, Supervisor

file = Path(sys.argv[1], "started")
script = f"test -e {file} && kill -TERM $PPID; touch {file}; exit 3"
with Supervisor(lambda line: print(line.partition(" See")[0])) as supervisor:
    supervisor.add(Child("worker", ["sh", "-c", script], {}, Path(sys.argv[1], "log")))
    print(supervisor.wait(100.0).name)
"""


def outcome_of(program: str, folder: Path) -> str:
    """Return what a program prints that has a supervisor."""
    command = [sys.executable, "-c", program, str(folder)]
    ended = subprocess.run(command, capture_output=True, text=True, check=True, timeout=120)
    return ended.stdout


def test_a_child_that_retires_stays_away_and_its_successor_runs_on(tmp_path: Path) -> None:
    said = outcome_of(RETIRING, tmp_path)

    first, second = (tmp_path / "pids").read_text().split()
    assert first != second
    assert said == "True None [] []\n"


@pytest.mark.slow
def test_a_supervisor_to_which_nothing_happens_looks_at_no_process(tmp_path: Path) -> None:
    assert outcome_of(IDLE, tmp_path) == "[]\n"


def test_a_dead_orphan_is_reaped_and_the_child_goes_on(tmp_path: Path) -> None:
    assert outcome_of(ORPHAN, tmp_path) == "None []\n"


@pytest.mark.slow
def test_a_child_that_dies_is_started_again_however_long_the_supervisor_would_wait(
    tmp_path: Path,
) -> None:
    said = outcome_of(RESTARTED, tmp_path)

    assert said == "worker ended (exit code 3); it restarts in 0.5 s.\nSIGTERM\n"
