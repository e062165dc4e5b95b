"""The command line of the Celery worker; importing it does not load Celery."""

import secrets

from seamark.server.settings import Settings

_CELERY = ("-s", "-P", "-m", "celery", "-A", "seamark.worker.service.app")


def worker_arguments(settings: Settings, *, quiet: bool = False) -> list[str]:
    """Return the arguments of the Python interpreter that start a worker, `quiet` without a banner.

    The name of each is its own: during a rolling restart a host has two workers, and a process
    takes over what one of the same name has left.
    """
    name = f"seamark-{secrets.token_hex(4)}@%h"
    return [
        *_CELERY,
        *(["--quiet"] if quiet else []),
        *("worker", "-P", "prefork", "-c", str(settings.workers)),
        *("--without-gossip", "--without-mingle"),
        *("-n", name, "--loglevel", "WARNING"),
    ]
