"""How the processes of Celery are started, without starting them."""

from seamark.server.settings import Settings


def worker_arguments(settings: Settings) -> list[str]:
    """Return the command line of a worker, after the interpreter."""
    return [
        *(
            "-s",
            "-P",
            "-m",
            "celery",
            "-A",
            "seamark.worker.service.app",
            "worker",
            "-P",
            "prefork",
        ),
        *("-c", str(settings.workers), "--without-gossip", "--without-mingle"),
        *("-n", "seamark@%h", "--loglevel", "WARNING"),
    ]


def beat_arguments(settings: Settings) -> list[str]:
    """Return the command line of beat, after the interpreter."""
    schedule = str(settings.data / "beat-schedule")
    return [
        *("-s", "-P", "-m", "celery", "-A", "seamark.worker.service.app", "beat"),
        *("-s", schedule, "--pidfile", "", "--loglevel", "WARNING"),
    ]
