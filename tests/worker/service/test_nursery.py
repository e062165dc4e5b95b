"""Side processes that are forked: they see what those of a new interpreter see, and cost less."""

import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from seamark.sandbox.isolation.proc_stats import parent_of, threads, tree
from tests.worker.conftest import START_S, Service
from tests.worker.processes import command_line
from tests.worker.service.test_side_processes import MARKS, eventually, is_running, pid_of

NURSERY = "seamark.worker.service.nursery"
HEAVY = (b"llvmlite", b"/cv2/", b"/scipy/", b"pybullet", b"onnxruntime")
# What a side process is, and how it ends.
MODULE = """
import json, os, resource, signal, sys, time

def main(parent, what, path):
    if what == "tells":
        status = open("/proc/self/status").read().splitlines()
        kept = ("Uid", "Gid", "Groups", "Sig", "Cap", "NoNewPrivs", "Seccomp", "Threads", "Cpus_")
        seen = {
            "descriptors": {n: os.readlink(f"/proc/self/fd/{n}") for n in range(60) if opened(n)},
            "signals": [str(signal.getsignal(n)) for n in sorted(signal.valid_signals())],
            "limits": [resource.getrlimit(n) for n in range(16)],
            "status": [line for line in status if line.startswith(kept) and "SigQ" not in line],
            "environment": dict(os.environ),
            "folder": os.getcwd(),
            "umask": os.umask(0),
            "arguments": open("/proc/self/cmdline").read().rstrip("\\0").split("\\0"),
            "parent": int(parent) == os.getppid(),
        }
        seen["arguments"].remove(parent)
        with open(path + ".part", "w") as file:
            json.dump(seen, file)
        os.rename(path + ".part", path)
    elif what == "dies":
        os._exit(3)
    elif what == "raises":
        raise LookupError
    time.sleep(600)

def opened(number):
    try:
        os.fstat(number)
    except OSError:
        return False
    return True

if __name__ == "__main__":
    main(*sys.argv[1:])
"""
# A worker that has descriptors, a handler and a blocked signal of its own, and a long command.
WORKER = """
import json, os, signal, socket, subprocess, sys, tempfile, time
from pathlib import Path
from seamark.worker.service.nursery import Nursery, spawn

opened = [socket.socket(), tempfile.TemporaryFile()]
signal.signal(signal.SIGTERM, lambda *_: None)
signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGUSR1})
nursery = Nursery.fork()
"""
COMPARES = """
for start, path in ((spawn, "spawned"), (nursery.start, "forked")):
    other = nursery.start(["-m", "side", "lives", ""])
    process = start(["-m", "side", "tells", path])
    while not Path(path).exists():
        time.sleep(0.01)
    for one in (process, other):
        one.send_signal(signal.SIGKILL)
        assert one.wait(30.0) == -signal.SIGKILL, one.wait()
"""
ENDS = """
ends = {}
for what in ("dies", "raises"):
    ends[what] = nursery.start(["-m", "side", what, ""]).wait(30.0)
lives = nursery.start(["-m", "side", "lives", ""])
ends["lives"] = lives.poll()
try:
    lives.wait(0.1)
except subprocess.TimeoutExpired:
    ends["waited"] = None
lives.send_signal(signal.SIGTERM)
ends["stopped"] = lives.wait(30.0)
lives.send_signal(signal.SIGTERM)
orphan = nursery.start(["-m", "side", "lives", ""])
nursery.close()
ends["orphan"] = orphan.wait(30.0)
spawned = nursery.start(["-m", "side", "dies", ""])
ends["spawned"] = [type(spawned).__name__, spawned.wait(30.0)]
print(json.dumps(ends))
"""
THREADED = """
import threading
from seamark.worker.service.nursery import Nursery

threading.Thread(target=threading.Event().wait, daemon=True).start()
print(Nursery.fork())
"""


def run(script: str, folder: Path) -> str:
    """Return what a script prints that has the module `side`."""
    (folder / "side.py").write_text(MODULE, encoding="utf-8")
    found = subprocess.run(
        [sys.executable, "-c", script, "room for the command of a side process" * 5],
        env=os.environ | {"PYTHONPATH": str(folder), "OPENBLAS_NUM_THREADS": "1"},
        cwd=folder,
        stdout=subprocess.PIPE,
        text=True,
        check=True,
        timeout=120,
    )
    return found.stdout


@pytest.mark.slow
def test_a_forked_side_process_sees_what_one_of_a_new_interpreter_sees(tmp_path: Path) -> None:
    run(WORKER + COMPARES, tmp_path)

    spawned, forked = (json.loads((tmp_path / one).read_text()) for one in ("spawned", "forked"))

    assert list(forked["descriptors"]) == ["0", "1", "2"]
    assert forked["parent"]
    assert forked.pop("arguments")[:-1] == spawned.pop("arguments")[:-1]  # the last is the path
    assert forked == spawned


@pytest.mark.slow
def test_a_worker_learns_how_each_forked_side_process_ends(tmp_path: Path) -> None:
    ends = json.loads(run(WORKER + ENDS, tmp_path))

    assert ends == {
        "dies": 3,
        "raises": 70,
        "lives": None,
        "waited": None,
        "stopped": -signal.SIGTERM,
        "orphan": -signal.SIGKILL,
        "spawned": ["Popen", 3],
    }


def test_nothing_is_forked_from_a_process_with_threads(tmp_path: Path) -> None:
    assert run(THREADED, tmp_path).splitlines()[-1] == "None"


@pytest.fixture(scope="module")
def running(_bare: Service) -> Service:
    """A service with a worker that has loaded nothing but what it loads itself."""
    _bare.start_worker_anew()
    return _bare


@pytest.mark.slow
@pytest.mark.host
def test_a_nursery_has_one_thread_and_no_connection(running: Service) -> None:
    eventually(lambda: is_running(running), START_S)
    [nursery] = _nurseries(running)

    opened = [os.readlink(one) for one in Path(f"/proc/{nursery}/fd").iterdir()]
    to_others = [one for one in opened if one.startswith("socket:")]

    assert len(threads([nursery])) == 1
    # One end for requests, one on which side processes ask for zygotes, and one for each of them:
    # other processes have the others.
    assert len(to_others) == 2 + sum(parent_of(pid) == nursery for pid in tree(nursery))


@pytest.mark.slow
@pytest.mark.host
def test_side_processes_are_forked_and_load_no_simulator(running: Service) -> None:
    eventually(lambda: is_running(running), START_S)
    [nursery] = _nurseries(running)

    found = _side_processes(running)
    loaded = {pid: Path(f"/proc/{pid}/maps").read_bytes() for pid in (nursery, *found)}

    assert {parent_of(pid) for pid in found} == {nursery}
    assert [name for name in HEAVY if any(name in maps for maps in loaded.values())] == []


@pytest.mark.slow
@pytest.mark.host
def test_a_worker_that_tests_fork_has_the_processes_of_one_that_is_started(
    running: Service,
) -> None:
    started, forked = running.workers[0].pid, running.start_worker().pid

    same = eventually(lambda: (found := _modules(forked)) == _modules(started) and found)

    assert same.count("seamark.worker.service.check_loop") == 2


@pytest.mark.slow
@pytest.mark.host
def test_side_processes_run_again_after_their_nursery_was_killed(running: Service) -> None:
    worker = running.workers[0].pid
    eventually(lambda: is_running(running), START_S)
    [nursery], before = _nurseries(running), _side_processes(running)

    os.kill(nursery, signal.SIGKILL)
    eventually(lambda: not set(before) & set(tree(worker)))
    after = eventually(lambda: len(found := _side_processes(running)) == len(before) and found)

    assert {parent_of(pid) for pid in after} == {worker}
    assert eventually(lambda: is_running(running)).alive


def _modules(worker: int) -> list[str]:
    """Return the module that each process of a worker runs."""
    commands = [command_line(pid).decode() for pid in tree(worker)]
    found = [re.search(r"seamark\.worker\.[\w.]+", command) for command in commands]
    return sorted(module[0] for module in found if module)


def _nurseries(service: Service) -> list[int]:
    worker = service.workers[0].pid
    return [pid for pid in tree(worker) if NURSERY.encode() in command_line(pid)]


def _side_processes(service: Service) -> list[int]:
    worker = service.workers[0].pid
    return [pid for mark in MARKS.values() if (pid := pid_of(mark, worker))]
