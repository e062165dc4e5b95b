"""The health check of a worker that is cut off."""

from seamark.server.settings import Settings
from seamark.worker.service import ping

NOWHERE = {
    "broker_url": "redis://127.0.0.1:1/0",
    "database_url": "postgresql://nobody@127.0.0.1:1/none?connect_timeout=1",
}


def test_a_worker_without_broker_and_database_does_not_count_as_hanging(settings: Settings) -> None:
    cut_off = settings.model_copy(update=NOWHERE)

    assert ping.problem(cut_off) is None
