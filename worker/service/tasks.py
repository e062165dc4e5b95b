"""What Celery calls: the task of a ticket, and the start and end of its processes."""

import mmap
import os
from typing import Any

import structlog
from billiard import current_process
from celery.signals import (
    worker_init,
    worker_process_init,
    worker_process_shutdown,
    worker_ready,
    worker_shutting_down,
)

from seamark.server.messaging import broker
from seamark.worker.service.app import app, settings
from seamark.worker.service.host import Host
from seamark.worker.service.run_loop import Member

_log = structlog.get_logger()
# One byte that the pool's children share with their parent: it can tell them to stop, while Celery
# itself would wait for minutes until their runs have ended.
_stop = mmap.mmap(-1, 1)
_state: dict[str, Any] = {}


@app.task(name=broker.WORK)
def work() -> None:
    """Answer a ticket: evaluate the fairest run, if there is one."""
    _member().work()


@worker_init.connect
def _begin(sender: Any, **_: object) -> None:
    """Find out what this host can do; the pool's children inherit the answer."""
    _state["host"] = Host.look(settings, name=str(sender.hostname))


@worker_ready.connect
def _ready(**_: object) -> None:
    _state["host"].supervise()


@worker_process_init.connect
def _begin_child(**_: object) -> None:
    _member()


@worker_process_shutdown.connect
def _end_child(**_: object) -> None:
    member = _state.pop("member", None)
    if member is not None:
        member.close()


@worker_shutting_down.connect
def _shutting_down(**_: object) -> None:
    _stop[0] = 1
    _state["host"].leave()
    _log.info("worker_stopping", worker=_state["host"].name)


class _Stop:
    """The shared byte as a `seamark.worker.service.run_driver.StopFlag`."""

    def is_set(self) -> bool:
        """Return whether the worker shuts down."""
        return _stop[0] != 0


def _member() -> Member:
    """Return this process's own database, broker and simulator, made at the first call."""
    member: Member | None = _state.get("member")
    if member is None or member.pid != os.getpid():
        index = int(getattr(current_process(), "index", 0) or 0)
        member = Member(app, settings, _state["host"], index=index, stopping=_Stop())
        _state["member"] = member
    return member
