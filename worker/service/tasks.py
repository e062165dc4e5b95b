"""What Celery calls: the task of a ticket, and the start and end of its processes."""

import gc
import mmap
import os
from dataclasses import replace
from functools import partial
from typing import Any

import structlog
from billiard import current_process
from celery.signals import (
    worker_init,
    worker_process_init,
    worker_process_shutdown,
    worker_ready,
    worker_shutdown,
    worker_shutting_down,
)
from sqlalchemy.orm import configure_mappers

from seamark.server.database.result_code import result_code
from seamark.server.messaging import broker
from seamark.worker.service.app import app, settings
from seamark.worker.service.host import Host
from seamark.worker.service.nursery import Nursery, spawn
from seamark.worker.service.run_loop import RunLoop
from seamark.worker.service.side_processes import SideProcesses
from seamark.worker.zygote.client import Mother

_log = structlog.get_logger()
# One byte that the pool's children share with their parent, which sets it at a shutdown. Celery
# itself would wait for minutes until their runs have ended.
_stop = mmap.mmap(-1, 1)
_state: dict[str, Any] = {}


@app.task(name=broker.WORK)
def work() -> None:
    """Answer a ticket: evaluate the fairest run, if there is one."""
    _run_loop().run_next()


@worker_init.connect
def _probe_host(sender: Any, **_: object) -> None:
    """Find out what this host can do, and with which code; what is forked later inherits it."""
    result_code()
    configure_mappers()
    host = Host.probe(settings, name=str(sender.hostname))
    mother = Mother.start(host.slot(0), settings.data / "compiled")
    _state["mother"] = mother
    _state["host"] = replace(host, mother=mother.descriptor)
    gc.freeze()  # what is loaded stays, and forks share it as long as nobody touches it
    gc.enable()  # see seamark.worker.service.main_process
    # Celery has neither threads nor connections yet.
    _state["nursery"] = Nursery.fork(kept=[mother.descriptor])


@worker_ready.connect
def _start_side_processes(**_: object) -> None:
    if _stop[0]:
        return
    host: Host = _state["host"]
    nursery: Nursery | None = _state["nursery"]
    # Their first report lists the worker; their thread takes it off the list again.
    side_processes = SideProcesses(
        host.side_process_commands(),
        host.heartbeat,
        leave=host.unregister,
        start=nursery.start if nursery else partial(spawn, kept=[host.mother]),
    )
    side_processes.start()
    _state["side_processes"] = side_processes


@worker_process_init.connect
def _start_child(**_: object) -> None:
    _run_loop()


@worker_process_shutdown.connect
def _end_child(**_: object) -> None:
    run_loop: RunLoop | None = _state.pop("run_loop", None)
    if run_loop is not None:
        run_loop.close()


@worker_shutting_down.connect
def _shut_down(**_: object) -> None:
    _stop[0] = 1
    if "side_processes" in _state:
        _state["side_processes"].stop()
    _log.info("worker_stopping", worker=_state["host"].name)


@worker_shutdown.connect
def _end(**_: object) -> None:
    if "side_processes" in _state:
        _state["side_processes"].stop()  # a signal may have come just before they were started
        _state["side_processes"].join()
    nursery: Nursery | None = _state["nursery"]
    if nursery is not None:
        nursery.close()
    _state["mother"].stop()


def _run_loop() -> RunLoop:
    """Return the run loop of this process, made at the first call."""
    run_loop: RunLoop | None = _state.get("run_loop")
    if run_loop is None or run_loop.pid != os.getpid():
        index = int(getattr(current_process(), "index", 0) or 0)
        run_loop = RunLoop(
            app, settings, _state["host"], index=index, shutting_down=lambda: _stop[0] != 0
        )
        _state["run_loop"] = run_loop
    return run_loop
