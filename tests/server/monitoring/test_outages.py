"""What the log says while a part of the service is away."""

from collections.abc import MutableMapping
from typing import Any

import pytest
from sqlalchemy.exc import OperationalError
from structlog.testing import capture_logs

from seamark.server.monitoring.outages import WHY_MAX, Outage
from seamark.worker.service.maintenance import PeriodicTask, run_due

Lines = list[MutableMapping[str, Any]]
AWAY = OperationalError("SELECT 1", None, OSError("refused\nIs the server running?"))


def _told(every_s: float) -> Lines:
    outage = Outage("database", every_s=every_s, worker="w")
    with capture_logs() as lines:
        outage.over()
        for _ in range(100):
            outage.failed(AWAY)
        outage.over()
        outage.over()
    return lines


def test_an_outage_is_told_once_and_how_often_it_was_tried_when_it_is_over() -> None:
    first, last = _told(every_s=3600.0)

    assert (first["event"], first["failures"], first["worker"]) == ("database_away", 1, "w")
    assert first["why"] == "OperationalError: (builtins.OSError) refused"
    assert (last["event"], last["failures"]) == ("database_back", 100)


def test_a_long_outage_is_told_again_after_a_while() -> None:
    *away, last = _told(every_s=0.0)

    assert [line["failures"] for line in away] == list(range(1, 101))
    assert last["event"] == "database_back"


def test_a_library_that_says_much_fills_no_log() -> None:
    with capture_logs() as lines:
        Outage("broker").failed(ConnectionError("x" * 10_000))

    assert len(lines[0]["why"]) == WHY_MAX


@pytest.mark.parametrize("times", [1, 50])
def test_maintenance_without_a_database_writes_one_line_and_no_traceback(times: int) -> None:
    def fail() -> None:
        raise AWAY

    task = PeriodicTask("fails", 0.0, fail)
    with capture_logs() as lines:
        for _ in range(times):
            run_due([task], on_duty=lambda: True)

    assert [line["event"] for line in lines] == ["database_away"]
    assert "exc_info" not in lines[0]
