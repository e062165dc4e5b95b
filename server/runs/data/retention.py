"""Which data of runs are deleted and when; what is left of dead attempts; the size of the rest.

A deletion has two steps: first the row says so, in one statement that no publication or worker can
overtake, then the files go. A crash between them leaves files that the next sweep removes.
"""

import shutil
import time
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import structlog
from sqlalchemy import ColumnElement, and_, false, func, or_, select, update
from sqlalchemy.orm import Session

from seamark.server.accounts.permissions import REJUDGEMENTS
from seamark.server.database import counters
from seamark.server.database.competition_tables import Competition, Entry, Round
from seamark.server.database.engine import Database
from seamark.server.database.queue_tables import Counter
from seamark.server.database.tables import IS_LISTED, Result, Run, RunFile, RunPart
from seamark.server.monitoring import meters
from seamark.server.programs import store
from seamark.server.runs.data import run_objects
from seamark.server.runs.data.files import RUNS_PER_FOLDER, RunFiles
from seamark.server.runs.data.run_objects import Attempt
from seamark.server.runs.record.states import FINAL, RunKind, RunState
from seamark.server.settings import Settings
from seamark.server.storage import objects, storage
from seamark.server.storage.objects import Objects, ObjectsAway

BATCH = (
    50  # runs whose data are deleted in one transaction: the write lock is held for milliseconds
)
MEASURED_AFTER_S = 60.0  # after the end of a run: until then its worker measures it
ORPHAN_KEPT_S = 86_400.0
SWEEP_OBJECTS_S = 30.0
_SWEPT = "objects_swept_at"  # counter: when a worker last swept the object storage
WHY_NOT = "The data of live and of public runs cannot be deleted, nor can they be deleted twice."
_DAY_S = 86_400.0
_log = structlog.get_logger()
# A final evaluates the programs that were submitted before.
_IN_COMPETITION = (
    select(Entry.run_id)
    .join(Round, Round.id == Entry.round_id)
    .join(Competition, Competition.id == Round.competition_id)
    .where(Entry.run_id == Run.id, Competition.ended_at.is_(None))
    .exists()
)
_DELETABLE = and_(
    *(Run.state.in_(FINAL), Run.public.is_(False), Run.data_deleted_at.is_(None)),
    or_(Run.kind != RunKind.ENTRY, ~_IN_COMPETITION),
)


def delete(database: Database, settings: Settings, run_ids: Collection[int]) -> list[int]:
    """Delete the data of those of these runs that have ended and are private; return which."""
    with database.writing() as session:
        marked = mark(session, run_ids)
    for run_id in marked:
        remove_files(settings, run_id)
    return marked


def mark(session: Session, run_ids: Collection[int]) -> list[int]:
    """Record that the data of runs are deleted, where that is allowed; return of which.

    The caller commits, then removes the files; a sweep removes those of a rejudgement.
    """
    change = (
        update(Run)
        .where(Run.id.in_(run_ids), _DELETABLE)
        .values(data_deleted_at=time.time(), data_bytes=0, data_measured=True)
    )
    marked = sorted(session.scalars(change.returning(Run.id)))
    again = update(Run).where(Run.rejudges.in_(marked), Run.data_deleted_at.is_(None))
    session.execute(again.values(data_deleted_at=time.time(), data_bytes=0, data_measured=True))
    return marked


def trim(database: Database, settings: Settings) -> None:
    """Delete the oldest private practice data while all data take more than `retention_bytes`.

    At most `BATCH` runs at a time.
    """
    if storage.is_away(settings):
        return
    if chosen := to_trim(database, settings):
        deleted = delete(database, settings, chosen)
        meters.RETENTION_RUNS.labels("size").inc(len(deleted))
        _log.info("data_trimmed", runs=len(deleted))


def to_trim(database: Database, settings: Settings) -> list[int]:
    """Return the runs that `trim` deletes next, at most `BATCH`."""
    practice = (Run.kind != RunKind.RANKED, Run.data_bytes > 0, _DELETABLE, IS_LISTED)
    oldest = select(Run.id, Run.data_bytes).where(*practice).order_by(Run.id).limit(BATCH)
    with database.reading() as session:
        excess = excess_bytes(session, settings)
        rows = session.execute(oldest).all() if excess > 0 else []
    chosen: list[int] = []
    for run_id, size in rows:
        if excess > 0:
            chosen.append(run_id)
            excess -= size
    return chosen


def excess_bytes(session: Session, settings: Settings) -> int:
    """Return by how much all data exceed `retention_bytes` [B]; 0 or less: they do not."""
    if not settings.retention_bytes:
        return 0
    counted = (Run.data_bytes > 0, Run.owner.not_like(f"{REJUDGEMENTS}%"))  # as an index has it
    total = session.scalar(select(func.sum(Run.data_bytes)).where(*counted)) or 0
    return int(total) - settings.retention_bytes


# What was uploaded for runs beside what their rows name.
_FURTHER = (
    select(RunPart.run_id, RunPart.program_sha256).join(Run),
    select(RunFile.run_id, RunFile.sha256).join(Run),
)


@dataclass(frozen=True, slots=True)
class _Row:
    """What the sweep needs to know of a run."""

    id: int
    state: str
    attempt: int
    finished_at: float | None
    data_measured: bool
    data_deleted_at: float | None
    program_sha256: str | None
    vehicle_sha256: str | None


class Sweep:
    """Passes over all runs again and again, a folder of them at each step."""

    def __init__(self, database: Database, settings: Settings) -> None:
        self._database, self._settings = database, settings
        self._stored = objects.of(settings)
        self._next = 0

    def step(self) -> None:
        """Sweep the newest folder of runs, and the next one of the others."""
        if storage.is_away(self._settings) or not self._is_in_turn():
            return
        folders = self._folders()
        if not folders:
            return
        self._next = (self._next + 1) % len(folders)
        for folder in {folders[-1], folders[self._next]}:
            self._sweep(folder)

    def _folders(self) -> list[int]:
        """Return the numbers of the folders of runs: those that exist, and those of the rows."""
        return sorted({*self._numbers(), *folders(self._database)})

    def _sweep(self, folder: int) -> None:
        within = _within(folder)
        columns = [getattr(Run, name) for name in _Row.__dataclass_fields__]
        with self._database.reading() as session:
            rows = {row.id: _Row(*row) for row in session.execute(select(*columns).where(within))}
            further = [
                (run_id, sha256)
                for query in _FURTHER
                for run_id, sha256 in session.execute(query.where(within))
            ]
            expired = _expired(session, within, self._settings)
        sizes = self._tidied(folder, rows)
        self._measure(rows.values(), sizes, further)
        if expired:
            deleted = delete(self._database, self._settings, expired)
            meters.RETENTION_RUNS.labels("age").inc(len(deleted))
            _log.info("data_expired", runs=len(deleted))

    def _is_in_turn(self) -> bool:
        """Return whether this worker sweeps now: of object storage one does, for all of them."""
        if self._stored is None:
            return True
        due = (Counter.name == _SWEPT, Counter.value < time.time() - SWEEP_OBJECTS_S)
        with self._database.writing() as session:
            if not counters.value(session, _SWEPT):
                counters.store(session, _SWEPT, 1.0)
            change = update(Counter).where(*due).values(value=time.time())
            return session.scalar(change.returning(Counter.name)) is not None

    def _numbers(self) -> set[int]:
        """Return the numbers of the folders of runs that exist."""
        if self._stored is not None:
            return {int(name) for name in self._stored.folders("runs")}
        return {int(entry.name) for entry in _numbered(self._settings.data / "runs")}

    def _tidied(self, folder: int, rows: Mapping[int, _Row]) -> Mapping[int, int]:
        """Tidy a folder of runs; return the sizes of the newest attempts that have objects."""
        if self._stored is None:
            for entry in _numbered(self._settings.data / "runs" / str(folder)):
                self._tidy(entry, rows.get(int(entry.name)))
            return {}
        grouped = run_objects.grouped(self._stored.list(f"runs/{folder}"))
        for run_id, attempts in grouped.items():
            self._tidy_objects(self._stored, run_id, attempts, rows.get(run_id))
        return {run_id: attempts[max(attempts)].size for run_id, attempts in grouped.items()}

    def _tidy_objects(
        self, stored: Objects, run_id: int, attempts: Mapping[int, Attempt], row: _Row | None
    ) -> None:
        """Remove the objects of a deleted run, of dead attempts, or of no run."""
        if row is None:
            if max(one.changed_at for one in attempts.values()) < time.time() - ORPHAN_KEPT_S:
                run_objects.remove(stored, run_id)
        elif row.data_deleted_at is not None:
            run_objects.remove(stored, run_id)
        else:
            kept = row.attempt if row.state in FINAL else _kept_attempt(row) or 0
            run_objects.remove_before(stored, run_id, kept)

    def _tidy(self, folder: Path, row: _Row | None) -> None:
        """Remove what a folder has of a deleted run, of dead attempts, or of no run."""
        run_id = int(folder.name)
        if row is None:
            if _older_than(folder, ORPHAN_KEPT_S):
                remove_files(self._settings, run_id)
        elif row.data_deleted_at is not None:
            remove_files(self._settings, run_id)
        else:
            RunFiles(self._settings.data, run_id, _kept_attempt(row)).remove_earlier_attempts()

    def _measure(
        self,
        rows: Iterable[_Row],
        of_objects: Mapping[int, int],
        further: Iterable[tuple[int, str]],
    ) -> None:
        """Record the size of runs that ended without their worker, or in an earlier version.

        `further` are runs and the SHA-256 of each further program or file.
        """
        due = time.time() - MEASURED_AFTER_S
        sizes: dict[int, int] = {
            row.id: self._size(row, of_objects) + self._uploaded_size(row)
            for row in rows
            if not row.data_measured and row.finished_at is not None and row.finished_at < due
        }
        for run_id, sha256 in further:
            if run_id in sizes:
                sizes[run_id] += store.size(self._settings, sha256)
        unmeasured = (Run.data_measured.is_(False), Run.data_deleted_at.is_(None))
        for batch in _batches(sorted(sizes)):
            with self._database.writing() as session:
                for run_id in batch:
                    change = update(Run).where(Run.id == run_id, *unmeasured)
                    session.execute(change.values(data_bytes=sizes[run_id], data_measured=True))

    def _size(self, row: _Row, of_objects: Mapping[int, int]) -> int:
        if self._stored is not None:
            return of_objects.get(row.id, 0)
        return RunFiles(self._settings.data, row.id).size()

    def _uploaded_size(self, row: _Row) -> int:
        uploads = (row.program_sha256, row.vehicle_sha256)
        return sum(store.size(self._settings, sha256) for sha256 in uploads if sha256 is not None)


def _kept_attempt(row: _Row) -> int | None:
    """Return the first attempt whose files are kept; None: the last one that has any.

    The attempt is the fencing token: of a running run only the worker of the latest one may still
    write, of a queued run only that of the next one.
    """
    if row.state in FINAL:
        return None
    return row.attempt + 1 if row.state == RunState.QUEUED else row.attempt


def folders(database: Database) -> range:
    """Return the numbers of the folders in which runs of the database belong."""
    with database.reading() as session:
        newest = session.scalar(select(func.max(Run.id)))
    return range(0 if newest is None else newest // RUNS_PER_FOLDER + 1)


def expired(database: Database, settings: Settings, folder: int) -> list[int]:
    """Return runs of a folder whose data are too old, at most `BATCH`."""
    with database.reading() as session:
        return _expired(session, _within(folder), settings)


def rules(settings: Settings) -> dict[str, ColumnElement[bool]]:
    """Return which data are too old: the condition on the runs of accounts and of guests.

    The best ranked run of each user in each benchmark is kept all the same.
    """
    now, deletable = time.time(), and_(_DELETABLE, IS_LISTED)
    by_account = or_(Run.user_id.is_not(None), Run.kind == RunKind.ENTRY)  # of a team
    days = {
        "accounts": (by_account, settings.retention_days),
        "guests": (~by_account, settings.guest_retention_days),
    }
    return {
        name: and_(deletable, owners, Run.finished_at < now - number * _DAY_S)
        for name, (owners, number) in days.items()
        if number
    }


def _within(folder: int) -> ColumnElement[bool]:
    first = folder * RUNS_PER_FOLDER
    return Run.id.between(first, first + RUNS_PER_FOLDER - 1)


def _expired(session: Session, within: ColumnElement[bool], settings: Settings) -> list[int]:
    """Return runs whose data are too old, at most `BATCH`."""
    old = (within, or_(false(), *rules(settings).values()))
    rows = session.execute(select(Run.id, Run.kind, Run.user_id, Run.benchmark).where(*old))
    old_ids = (
        row.id
        for row in rows
        if row.kind != RunKind.RANKED or row.id != _best(session, row.user_id, row.benchmark)
    )
    return list(islice(old_ids, BATCH))


def _best(session: Session, user_id: int, benchmark: str) -> int | None:
    """Return the best ranked run of a user in a benchmark: it may still be published."""
    ranked = (Run.kind == RunKind.RANKED, Run.state == RunState.SUCCEEDED)
    best = (
        select(Run.id)
        .join(Result, Result.run_id == Run.id)
        .where(Run.user_id == user_id, Run.benchmark == benchmark, *ranked)
        .where(Run.deleted_at.is_(None))
        .order_by(Result.score.desc(), Run.id)
        .limit(1)
    )
    return session.scalar(best)


def _numbered(folder: Path) -> list[Path]:
    """Return the entries of a folder whose names are numbers; none if there is no folder."""
    if not folder.is_dir():
        return []
    return [entry for entry in folder.iterdir() if entry.name.isdecimal()]


def _older_than(folder: Path, seconds: float) -> bool:
    try:
        return folder.stat().st_mtime < time.time() - seconds
    except FileNotFoundError:
        return False


def remove_files(settings: Settings, run_id: int) -> None:
    """Remove all files of a run; a later sweep removes what could not be removed now."""
    shutil.rmtree(RunFiles(storage.copies(settings), run_id).root, ignore_errors=True)
    stored = objects.of(settings)
    if stored is not None:
        try:
            run_objects.remove(stored, run_id)
        except ObjectsAway as error:
            _log.warning("objects_not_removed", run=run_id, error=str(error))


def _batches(run_ids: Sequence[int]) -> Iterable[Sequence[int]]:
    return (run_ids[at : at + BATCH] for at in range(0, len(run_ids), BATCH))
