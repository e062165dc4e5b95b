"""The measurement of what takes how much room, and the deletion that an admin asks for."""

import time

import numpy as np
import pytest
from sqlalchemy import update

from seamark.server.accounts import audit
from seamark.server.accounts.audit import Actor, AuditFilter
from seamark.server.administration import disk
from seamark.server.database.tables import Run, User
from seamark.server.runs.data import disk_usage
from seamark.server.runs.data.disk_usage import Report
from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.data.retention_pass import RetentionPass
from seamark.sim.recording.telemetry import WIDTH
from tests.cast import Backend

DAYS = 30
ROW_BYTES = 8 * WIDTH


def _aged(both: Backend, who: str, rows: int, days: float, **changes: str) -> int:
    """Return a run with telemetry that ended `days` ago."""
    claim = both.running(who, **changes)
    files = RunFiles(both.settings.data, claim.run_id, claim.attempt)
    files.append_rows(np.zeros((rows, WIDTH)))
    assert both.finish(claim, data_bytes=rows * ROW_BYTES)
    with both.database.writing() as session:
        ended = {"finished_at": time.time() - days * 86_400.0}
        session.execute(update(Run).where(Run.id == claim.run_id).values(**ended))
    return claim.run_id


def _report(both: Backend) -> Report:
    with both.database.reading() as session:
        return disk_usage.report(session)


def _carried_out(both: Backend) -> None:
    passing = RetentionPass(both.database, both.settings)
    for _ in range(100):
        passing.step()


def test_the_measurement_adds_up_runs_files_owners_and_what_is_due(both: Backend) -> None:
    both.settings = both.settings.model_copy(update={"retention_days": DAYS})
    _aged(both, "ann", 10, DAYS + 1)
    _aged(both, "ann", 20, DAYS - 1)
    both.publish(_aged(both, "eva", 40, DAYS + 1))
    both.store_program()

    disk_usage.measure(both.database, both.settings)

    found = _report(both)
    areas = {each.name: (each.bytes, each.count) for each in found.areas}
    assert areas["runs"] == (70 * ROW_BYTES, 3)
    assert areas["programs"][1] == 1
    assert areas["database"][0] > 10_000
    owners = [(each.name, each.bytes) for each in found.owners]
    ann, eva = (f"user:{both.user_id(name)}" for name in ("ann", "eva"))
    assert owners == [(eva, 40 * ROW_BYTES), (ann, 30 * ROW_BYTES)]
    with both.database.writing() as session:
        session.execute(update(User).where(User.name == "eva").values(is_baseline=True))
        shown = disk.state(session, both.settings).owners
    assert [(one.name, one.user_id) for one in shown] == [
        ("eva", None),
        ("ann", both.user_id("ann")),
    ]
    due = {each.name: (each.bytes, each.count) for each in found.due}
    assert due == {"accounts": (10 * ROW_BYTES, 1), "guests": (0, 0), "size": (0, 0)}


def test_a_recent_measurement_is_not_repeated(backend: Backend) -> None:
    disk_usage.measure_if_old(backend.database, backend.settings)
    first = _report(backend).measured_at
    disk_usage.measure_if_old(backend.database, backend.settings)

    assert _report(backend).measured_at == first > 0


@pytest.mark.parametrize("limit_rows", [0, 25])
def test_a_pass_deletes_all_that_is_due_and_says_how_much_that_was(
    both: Backend, limit_rows: int
) -> None:
    old, middle, new = (_aged(both, "ann", 20, days) for days in (DAYS + 2, 2, 1))
    public = both.publish(_aged(both, "eva", 1, DAYS + 1))
    limits = {"retention_days": DAYS, "retention_bytes": limit_rows * ROW_BYTES}
    both.settings = both.settings.model_copy(update=limits)
    with both.database.writing() as session:
        disk.request_retention(session, Actor("root"))

    _carried_out(both)

    gone = [run for run in (old, middle, new, public) if both.show(run).data_deleted_at]
    assert gone == ([old, middle] if limit_rows else [old])
    assert RunFiles(both.settings.data, old).attempts() == []
    assert RunFiles(both.settings.data, new).row_count() == 20
    with both.database.reading() as session:
        entries = audit.page(session, AuditFilter()).entries
        state = disk.state(session, both.settings)
    assert [entry.action for entry in entries] == ["retention_ended", "retention_requested"]
    assert entries[0].detail == {"runs": len(gone), "bytes": len(gone) * 20 * ROW_BYTES}
    assert (state.requested_at, state.due_runs) == (0.0, 0)


def test_nothing_is_deleted_unless_somebody_asks(both: Backend) -> None:
    both.settings = both.settings.model_copy(update={"retention_days": DAYS})
    run_id = _aged(both, "ann", 20, DAYS + 1)

    _carried_out(both)

    assert both.show(run_id).data_deleted_at is None
