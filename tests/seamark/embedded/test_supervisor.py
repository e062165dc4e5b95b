"""The supervisor in a process of its own: it would end all children of the tests."""

import subprocess
import sys
from pathlib import Path

PROGRAM = """
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


def test_a_child_that_retires_stays_away_and_its_successor_runs_on(
    tmp_path: Path,
) -> None:
    ended = subprocess.run(
        [sys.executable, "-c", PROGRAM, str(tmp_path)],
        capture_output=True,
        text=True,
        check=True,
        timeout=120,
    )

    first, second = (tmp_path / "pids").read_text().split()
    assert first != second
    assert ended.stdout == "True None [] []\n"
