"""The command line of the Celery worker; importing it does not load Celery."""

from seamark.server.settings import Settings

_CELERY = ("-s", "-P", "-m", "celery", "-A", "seamark.worker.service.app")


def worker_arguments(settings: Settings) -> list[str]:
    """Return the arguments of the Python interpreter that start a worker."""
    return [
        *_CELERY,
        *("worker", "-P", "prefork", "-c", str(settings.workers)),
        *("--without-gossip", "--without-mingle"),
        *("-n", "seamark@%h", "--loglevel", "WARNING"),
    ]
