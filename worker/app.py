"""The Celery application of worker and beat: `celery -A worker.app worker`."""

from server.broker import celery_app
from server.log import configure
from server.settings import Settings

configure()
settings = Settings.load()
app = celery_app(settings)
app.conf.update(include=["worker.tasks"])


def worker_arguments(chosen: Settings) -> list[str]:
    """Return the command line of a worker, after the interpreter."""
    return [
        *("-s", "-P", "-m", "celery", "-A", "worker.app", "worker", "-P", "prefork"),
        *("-c", str(chosen.workers), "--without-gossip", "--without-mingle"),
        *("-n", "seamark@%h", "--loglevel", "WARNING"),
    ]


def beat_arguments(chosen: Settings) -> list[str]:
    """Return the command line of beat, after the interpreter."""
    schedule = str(chosen.data / "beat-schedule")
    return [
        *("-s", "-P", "-m", "celery", "-A", "worker.app", "beat"),
        *("-s", schedule, "--pidfile", "", "--loglevel", "WARNING"),
    ]
