"""What loads without garbage collection collects afterwards: it would grow without an end."""

import os

import pytest

from seamark.server.settings import Settings
from tests.services.prepared import run

WORKER = """
import gc
from types import SimpleNamespace

gc.disable()
from seamark.worker.service import tasks

tasks._probe_host(SimpleNamespace(hostname="here"))
print(gc.isenabled())
"""
ZYGOTE = """
import gc, os, socket

gc.disable()
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.worker.evaluation.worker_slot import WorkerSlot
from seamark.worker.zygote import process

client, control = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
client.shutdown(socket.SHUT_WR)  # no job comes
process.warm_up = lambda _: None  # it is long, and what comes before and after is not
slot = WorkerSlot(IsolationLevel.NONE, None).to_json()
process.main([str(control.detach()), slot, str(os.getppid())])
print(gc.isenabled())
"""
WEB = """
import gc
from seamark.embedded.web_server import _Application
from seamark.server.settings import Settings

_Application(Settings.load(), {}).load()
print(gc.isenabled())
"""


@pytest.mark.slow
@pytest.mark.parametrize("script", [WORKER, ZYGOTE, WEB], ids=["worker", "zygote", "web"])
def test_a_process_that_has_loaded_its_modules_collects_garbage(
    script: str, settings: Settings
) -> None:
    found = run(script, environment=os.environ | settings.environment())

    assert found.returncode == 0, found.stderr
    assert found.stdout.splitlines()[-1] == "True"
