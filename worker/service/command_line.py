"""The command line of the Celery worker; importing it does not load Celery."""

import secrets

from seamark.server.settings import Settings

_CELERY = ("-s", "-P", "-m", "celery", "-A", "seamark.worker.service.app")


def worker_arguments(settings: Settings) -> list[str]:
    """Return the arguments of the Python interpreter that start a worker.

    The name of each is its own: during a rolling restart a host has two workers, and a process
    takes over what one of the same name has left.
    """
    name = f"seamark-{secrets.token_hex(4)}@%h"
    return [
        *_CELERY,
        *("worker", "-P", "prefork", "-c", str(settings.workers)),
        *("--without-gossip", "--without-mingle"),
        *("-n", name, "--loglevel", "WARNING"),
    ]
