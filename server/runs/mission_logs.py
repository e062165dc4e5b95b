"""Logs of missions on the service: kept and shown as runs of a kind of their own.

A log has ended when its row is inserted. No worker ever claims it, nothing computes it again, and
it never ranks.
"""

from __future__ import annotations

import json
import time

from sqlalchemy.orm import Session

from seamark.mission_logs.refusal import LogRefused
from seamark.mission_logs.result import LOG, LogResult
from seamark.server import objects, storage
from seamark.server.accounts.permissions import Viewer
from seamark.server.database.advisory_locks import AdvisoryLock, acquire
from seamark.server.database.engine import Database
from seamark.server.database.tables import Result, Run
from seamark.server.runs import quota, run_objects
from seamark.server.runs.error_curve import error_curve
from seamark.server.runs.files import RunFiles, StorageFailed
from seamark.server.runs.run_notes import clean_notes, clean_title
from seamark.server.runs.states import RunKind, RunState
from seamark.server.settings import Settings
from seamark.server.storage import StorageUnavailable
from seamark.sim.recording.telemetry import INDEX, POSE_COLUMNS

ATTEMPT = 1
NO_POSE = (
    "The player needs the vehicle's pose: x, y, z, and roll, pitch, yaw or a quaternion. `seamark "
    "replay` measures a log with corners alone."
)


def store(
    database: Database,
    settings: Settings,
    viewer: Viewer,
    found: LogResult,
    *,
    title: str,
    notes: str = "",
) -> int:
    """Store a measured log as a private run of the viewer, and return its number.

    Raises
    ------
    LogRefused
        It has no pose to show.
    QuotaExceeded
        The quota of runs or bytes is used up.
    StorageUnavailable
        There is no room, or the storage is away.
    """
    if set(POSE_COLUMNS) & set(found.manifest["absent"]):
        raise LogRefused(NO_POSE)
    storage.require(settings)
    documents = len(json.dumps(found.metrics)) + len(json.dumps(found.manifest))
    with database.writing() as session:
        acquire(session, AdvisoryLock.SUBMISSION)  # as of a submission: see there
        quota.enforce(session, viewer, settings, new_bytes=found.rows.nbytes + documents)
        run = _row(viewer, found, title=title, notes=notes)
        session.add(run)
        session.flush()
        files = RunFiles(storage.copies(settings), run.id, ATTEMPT)
        try:
            _write(settings, files, run.id, found)
            _insert_result(session, files, run, found)
            session.flush()
        except (StorageFailed, objects.ObjectsAway) as error:
            files.remove()
            raise StorageUnavailable(str(error)) from error
        return run.id


def _row(viewer: Viewer, found: LogResult, *, title: str, notes: str) -> Run:
    now = time.time()
    return Run(
        owner=viewer.owner,
        user_id=viewer.user_id,
        guest=None if viewer.user_id is not None else viewer.guest,
        benchmark=found.benchmark,
        kind=RunKind.LOG,
        config=found.config,
        seed=0,  # of the noise in the rendered images
        trials=found.trials,
        controller=LOG,
        title=clean_title(title),
        notes=clean_notes(notes),
        state=RunState.SUCCEEDED,
        attempt=ATTEMPT,
        queued_at=now,
        started_at=now,
        finished_at=now,
        progress=1.0,
        t_simulated=float(found.rows[:, INDEX["t"]].max()),
    )


def _write(settings: Settings, files: RunFiles, run_id: int, found: LogResult) -> None:
    files.append_rows(found.rows)
    files.write_json("metrics.json", found.metrics)
    files.write_json("manifest.json", found.manifest)
    stored = objects.of(settings)
    if stored is None:
        return
    folder = run_objects.folder(run_id, ATTEMPT)
    names = sorted(file.name for file in files.folder.iterdir())
    for name in names:
        stored.put(f"{folder}/{name}", files.folder / name)
    stored.put(f"{folder}/{run_objects.COMPLETE}", json.dumps(names).encode())


def _insert_result(session: Session, files: RunFiles, run: Run, found: LogResult) -> None:
    run.data_bytes, run.data_measured = files.size(), True
    session.add(
        Result(
            run_id=run.id,
            attempt=ATTEMPT,
            digest=found.digest,
            score=found.metrics["score"],
            level_held=found.metrics["level_held"],
            rankable=False,
            not_ranked=found.metrics["not_ranked"],
            error_curve=error_curve(files, found.benchmark),
            metrics=found.metrics,
            manifest=found.manifest,
            created_at=time.time(),
        )
    )
