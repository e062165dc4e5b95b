"""What takes how much room: measured by the maintenance of the workers, read by pages.

A page could neither look at all files nor add up the runs of a large service.
"""

import os
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from sqlalchemy import ColumnElement, Select, and_, delete, func, select
from sqlalchemy.orm import Session

from seamark.server.accounts.permissions import REJUDGEMENTS
from seamark.server.database import counters, engine
from seamark.server.database.engine import Database
from seamark.server.database.operation_tables import DiskUsage
from seamark.server.database.tables import Run
from seamark.server.runs.data import retention
from seamark.server.settings import Settings
from seamark.server.storage import storage

EVERY_S = 900.0  # between two measurements
OWNERS = 10  # who take most
MEASURED_AT = "disk_measured_at"
# Of the data folder; with object storage it has copies and what workers are about to upload.
_FOLDERS = ("programs", "compiled", "logs", "cache", "workspace")


class Kind(StrEnum):
    """What a row of the measurement is about."""

    AREA = "area"  # runs, database or a folder
    OWNER = "owner"  # of runs, as in `runs.owner`
    DUE = "due"  # what a rule of retention would delete now


@dataclass(frozen=True, slots=True)
class Usage:
    """Room that something takes [B], and in how many runs or files."""

    name: str
    bytes: int
    count: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Report:
    """A measurement; `measured_at` is 0 before the first one."""

    measured_at: float
    areas: Sequence[Usage]
    owners: Sequence[Usage]
    due: Sequence[Usage]


def report(session: Session) -> Report:
    """Return the last measurement, the largest first."""
    by_kind: dict[str, list[Usage]] = {kind: [] for kind in Kind}
    rows = select(DiskUsage).order_by(DiskUsage.bytes.desc(), DiskUsage.name)
    for row in session.scalars(rows):
        by_kind[row.kind].append(Usage(row.name, row.bytes, row.count))
    return Report(
        measured_at=counters.value(session, MEASURED_AT),
        areas=by_kind[Kind.AREA],
        owners=by_kind[Kind.OWNER],
        due=by_kind[Kind.DUE],
    )


def measure_if_old(database: Database, settings: Settings) -> None:
    """Measure, unless another worker has done so lately."""
    with database.reading() as session:
        measured_at = counters.value(session, MEASURED_AT)
    if abs(time.time() - measured_at) > EVERY_S:
        measure(database, settings)


def measure(database: Database, settings: Settings) -> None:
    """Measure everything and store it, unless the data folder is away."""
    if storage.is_away(settings):
        return
    with database.reading() as session:
        rows = [*_areas(session, settings), *_owners(session), *_due(session, settings)]
    with database.writing() as session:
        session.execute(delete(DiskUsage))
        session.add_all(rows)
        counters.store(session, MEASURED_AT, time.time())


def _areas(session: Session, settings: Settings) -> Iterator[DiskUsage]:
    size, count = session.execute(_sums(Run.data_bytes > 0)).one()
    yield _row(Kind.AREA, "runs", size, count)
    yield _row(Kind.AREA, "database", engine.size_bytes(session.connection()), 1)
    for name in _FOLDERS:
        folder = settings.data / name
        if folder.is_dir():
            yield _row(Kind.AREA, name, *_folder(folder))


def _owners(session: Session) -> Iterator[DiskUsage]:
    size = func.sum(Run.data_bytes).label("size")
    counted = (Run.data_bytes > 0, Run.owner.not_like(f"{REJUDGEMENTS}%"))
    query = select(Run.owner, size, func.count()).where(*counted).group_by(Run.owner)
    for owner, bytes_, count in session.execute(query.order_by(size.desc()).limit(OWNERS)):
        yield _row(Kind.OWNER, owner, bytes_, count)


def _due(session: Session, settings: Settings) -> Iterator[DiskUsage]:
    for name, rule in retention.rules(settings).items():
        size, count = session.execute(_sums(and_(rule, Run.data_bytes > 0))).one()
        yield _row(Kind.DUE, name, size, count)
    excess = retention.excess_bytes(session, settings)
    yield _row(Kind.DUE, "size", max(excess, 0), 0)


def _sums(condition: ColumnElement[bool]) -> Select[int | None, int]:
    return select(func.sum(Run.data_bytes), func.count()).where(condition)


def _row(kind: Kind, name: str, size: int | None, count: int) -> DiskUsage:
    return DiskUsage(kind=kind, name=name, bytes=int(size or 0), count=count)


def _folder(path: Path) -> tuple[int, int]:
    """Return the size [B] and the number of the files below a folder."""
    size = count = 0
    for folder, _, names in os.walk(path):
        for name in names:
            try:
                size += os.stat(os.path.join(folder, name), follow_symlinks=False).st_size
            except FileNotFoundError:
                continue
            count += 1
    return size, count
