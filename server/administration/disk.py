"""What takes how much room, what retention would delete, and the pass that does so at once."""

import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from seamark.server.accounts import audit
from seamark.server.accounts.audit import Actor, AuditAction, AuditFilter
from seamark.server.database.tables import User
from seamark.server.runs.data import disk_usage, retention_pass
from seamark.server.runs.data.disk_usage import Report, Usage
from seamark.server.settings import Settings

LAST_PASSES = 5
_USERS = "user:"


@dataclass(frozen=True, slots=True)
class Owner:
    """Somebody whose runs take much room."""

    user_id: int | None  # None: guests, a deleted account, or a baseline, which have no page
    name: str
    usage: Usage


@dataclass(frozen=True, slots=True)
class Event:
    """Something of the audit log."""

    at: float
    target: str
    detail: Mapping[str, Any]


@dataclass(frozen=True, slots=True, kw_only=True)
class Disk:
    """The state of the disk."""

    report: Report
    total_bytes: int  # of the disk of the data folder; 0: it cannot be reached
    free_bytes: int
    owners: Sequence[Owner]
    requested_at: float  # 0: no pass has been asked for that has not begun
    passes: Sequence[Event]  # the last ones, newest first
    backup: Event | None  # the last one

    @property
    def due_runs(self) -> int:
        """Runs whose data are too old."""
        return sum(rule.count for rule in self.report.due)


def state(session: Session, settings: Settings) -> Disk:
    """Return the state of the disk; everything large was measured before."""
    report = disk_usage.report(session)
    try:
        total, _, free = shutil.disk_usage(settings.data)
    except OSError:
        total = free = 0
    return Disk(
        report=report,
        total_bytes=total,
        free_bytes=free,
        owners=_owners(session, report.owners),
        requested_at=retention_pass.requested_at(session),
        passes=_last(session, AuditAction.RETENTION_ENDED, LAST_PASSES),
        backup=next(iter(_last(session, AuditAction.BACKUP_MADE, 1)), None),
    )


def request_retention(session: Session, actor: Actor) -> None:
    """Have the maintenance of a worker delete at once what retention would delete in time."""
    retention_pass.request(session)
    audit.record(session, actor, AuditAction.RETENTION_REQUESTED)


def _owners(session: Session, usages: Sequence[Usage]) -> list[Owner]:
    ids = {
        usage.name: int(usage.name.removeprefix(_USERS))
        for usage in usages
        if usage.name.startswith(_USERS)
    }
    query = select(User.id, User.name, User.is_baseline).where(User.id.in_(ids.values()))
    known = {user.id: user for user in session.execute(query)}
    return [_owner(usage, ids.get(usage.name), known) for usage in usages]


def _owner(usage: Usage, user_id: int | None, known: Mapping[int, Any]) -> Owner:
    if user_id is None:
        return Owner(None, "Guests of one network", usage)
    if user_id not in known:
        return Owner(None, "Deleted account", usage)
    user = known[user_id]
    return Owner(None if user.is_baseline else user_id, user.name, usage)


def _last(session: Session, action: AuditAction, count: int) -> list[Event]:
    entries = audit.page(session, AuditFilter(action=action), limit=count).entries
    return [Event(entry.at, entry.target, entry.detail) for entry in entries]
