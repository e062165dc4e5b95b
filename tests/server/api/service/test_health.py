"""What operators read: /status and /metrics."""

import pytest

from seamark.server.database.tables import Worker
from seamark.server.messaging import workers
from tests.server.api.conftest import Site


@pytest.fixture
def broken_checks(site: Site) -> Site:
    """A service whose only worker has a side process that does not stay up."""
    with site.database.writing() as session:
        row = Worker(name="w1@host", slots=2, level="strong", languages=["python"], findings=[])
        workers.register(session, row)
        states = {"maintenance": workers.RUNNING, "checks": "restarting since 12:00:05"}
        workers.heartbeat(session, "w1@host", states)
    return site


def test_the_status_page_names_a_broken_side_process(broken_checks: Site) -> None:
    page = broken_checks.client().get("/status").text

    assert "checks: restarting since 12:00:05" in page
    assert "maintenance:" not in page
    assert "Everything works" not in page


def test_the_metrics_tell_broken_side_processes_from_running_ones(broken_checks: Site) -> None:
    metrics = broken_checks.client().get("/metrics").text

    up = 'seamark_worker_process_up{process="%s",worker="w1@host"} %s'
    assert up % ("maintenance", "1.0") in metrics
    assert up % ("checks", "0.0") in metrics
    assert 'seamark_workers{state="ready"} 1.0' in metrics
