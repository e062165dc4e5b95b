"""The command line of the Celery worker; importing it does not load Celery."""

from __future__ import annotations

import secrets
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from seamark.server.settings import Settings

# The cores belong to the runs, and sums must not depend on threads.
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")
_CELERY = ("-m", "seamark.worker.service.main_process", "-A", "seamark.worker.service.app")


def worker_arguments(settings: Settings, *, quiet: bool = False) -> list[str]:
    """Return the arguments of the Python interpreter that start a worker, `quiet` without a banner.

    The name of each is its own: during a rolling restart a host has two workers, and a process
    takes over what one of the same name has left.
    """
    name = f"seamark-{secrets.token_hex(4)}@%h"
    return [
        *("-s", "-P"),
        *_CELERY,
        *(["--quiet"] if quiet else []),
        *("worker", "-P", "prefork", "-c", str(settings.workers)),
        *("--without-gossip", "--without-mingle"),
        *("-n", name, "--loglevel", "WARNING"),
    ]
