"""Logs of missions on the service: kept and shown as runs of a kind of their own.

A log has ended when its row is inserted. No worker ever claims it, nothing computes it again, and
it never ranks.
"""

from __future__ import annotations

import json
import time
from contextlib import ExitStack

from seamark.mission_logs.result import LOG, LogRefused, LogResult
from seamark.server.accounts.permissions import Viewer
from seamark.server.database.advisory_locks import AdvisoryLock, acquire
from seamark.server.database.engine import Database
from seamark.server.database.tables import Result, Run
from seamark.server.runs.data import retention
from seamark.server.runs.data.error_curve import error_curve
from seamark.server.runs.data.files import StorageFailed
from seamark.server.runs.data.staging import Staged, staged
from seamark.server.runs.record.run_notes import clean_notes, clean_title
from seamark.server.runs.record.states import RunKind, RunState
from seamark.server.runs.submission import quota
from seamark.server.settings import Settings
from seamark.server.storage import objects, storage
from seamark.server.storage.storage import StorageUnavailable
from seamark.sim.recording.telemetry import INDEX, POSE_COLUMNS

ATTEMPT = 1
WRITTEN_ROWS = 10_000  # of a file that is mapped: 5 MB in memory at a time
NO_POSE = (
    "The player needs the vehicle's pose: x, y, z, and roll, pitch, yaw or a quaternion. `seamark "
    "replay` measures a log with corners alone."
)


def require_room(database: Database, settings: Settings, viewer: Viewer) -> None:
    """Raise if a log would be refused however small it is, before it is measured.

    Raises
    ------
    QuotaExceeded, StorageUnavailable
        As `store`.
    """
    storage.require(settings)
    with database.reading() as session:
        quota.enforce(session, viewer, settings, new_bytes=0)


def store(
    database: Database,
    settings: Settings,
    viewer: Viewer,
    log: LogResult,
    *,
    title: str,
    notes: str = "",
) -> int:
    """Store a measured log as a private run of the viewer, and return its number.

    The files are written before the transaction, which has to be short: it keeps all submissions
    waiting, and with SQLite everybody who writes.

    Raises
    ------
    LogRefused
        It has no pose to show.
    QuotaExceeded
        The quota of runs or bytes is used up.
    StorageUnavailable
        There is no room, or the storage is away.
    """
    if set(POSE_COLUMNS) & set(log.manifest["absent"]):
        raise LogRefused(NO_POSE)
    storage.require(settings)
    new_bytes = log.rows.nbytes + len(json.dumps([log.metrics, log.manifest]))
    with database.reading() as session:
        quota.enforce(session, viewer, settings, new_bytes=new_bytes)
    run = _row(viewer, log, title=title, notes=notes)
    try:
        with staged(settings, attempt=ATTEMPT) as aside:
            result = _written(aside, run, log)
            return _insert(database, settings, viewer, run, result, aside)
    except (StorageFailed, objects.ObjectsAway) as error:
        raise StorageUnavailable(str(error)) from error


def _insert(
    database: Database,
    settings: Settings,
    viewer: Viewer,
    run: Run,
    result: Result,
    aside: Staged,
) -> int:
    """Insert a run with its result and move its files into their place; return its number."""
    with ExitStack() as undo, database.writing() as session:
        acquire(session, AdvisoryLock.SUBMISSION)  # as of a submission: see there
        quota.enforce(session, viewer, settings, new_bytes=run.data_bytes)
        session.add(run)
        session.flush()
        undo.callback(retention.remove_files, settings, run.id)
        aside.place(run.id)
        result.run_id = run.id
        session.add(result)
        session.flush()
        # Whether a commit that fails has happened is unknown: a sweep removes files without a row.
        undo.pop_all()
    return run.id


def _row(viewer: Viewer, log: LogResult, *, title: str, notes: str) -> Run:
    now = time.time()
    return Run(
        owner=viewer.owner,
        user_id=viewer.user_id,
        guest=None if viewer.user_id is not None else viewer.guest,
        benchmark=log.benchmark,
        kind=RunKind.LOG,
        config=log.config,
        seed=0,  # of the noise in the rendered images
        trials=log.trials,
        controller=LOG,
        title=clean_title(title),
        notes=clean_notes(notes),
        state=RunState.SUCCEEDED,
        attempt=ATTEMPT,
        queued_at=now,
        started_at=now,
        finished_at=now,
        progress=1.0,
        t_simulated=float(log.rows[:, INDEX["t"]].max()),
    )


def _written(aside: Staged, run: Run, log: LogResult) -> Result:
    """Write the files of a log aside, and return the row of its result, still without a run."""
    for at in range(0, len(log.rows), WRITTEN_ROWS):
        aside.files.append_rows(log.rows[at : at + WRITTEN_ROWS])
    aside.files.write_json("metrics.json", log.metrics)
    aside.files.write_json("manifest.json", log.manifest)
    aside.upload()
    run.data_bytes, run.data_measured = aside.files.size(), True
    return Result(
        attempt=ATTEMPT,
        digest=log.digest,
        score=log.metrics["score"],
        level_held=log.metrics["level_held"],
        rankable=False,
        not_ranked=log.metrics["not_ranked"],
        error_curve=error_curve(aside.files, log.benchmark),
        metrics=log.metrics,
        manifest=log.manifest,
        created_at=time.time(),
    )
