"""The audit log: who did what to whom, when and from where.

An entry is written in the transaction of what it tells, so that neither is there without the other.
Entries are deleted after `audit_days`.
"""

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from sqlalchemy import ColumnElement, delete, func, select
from sqlalchemy.orm import Session

from seamark.server.database.operation_tables import AuditEntry

PAGE, PAGE_MAX = 50, 200
SEEN_MAX = 2000  # entries that a page of a log with two or more filters looks at
BATCH = 1000  # entries that one transaction deletes
BLOCKED_PER_HOUR = 100  # entries of blocked sign-ins, whatever strangers try
TARGET_MAX = 255  # [character]
_HOUR_S, _DAY_S = 3600.0, 86_400.0


class AuditAction(StrEnum):
    """What was done."""

    SIGN_IN_BLOCKED = "sign_in_blocked"
    ROLE_CHANGED = "role_changed"
    QUOTA_CHANGED = "quota_changed"
    ACCOUNT_DISABLED = "account_disabled"
    ACCOUNT_ENABLED = "account_enabled"
    ACCOUNT_DELETED = "account_deleted"
    ACCESS_REVOKED = "access_revoked"
    RESET_LINK_MADE = "reset_link_made"
    PASSWORD_CHANGED = "password_changed"  # noqa: S105 - the name of an action
    IDENTITY_LINKED = "identity_linked"
    IDENTITY_UNLINKED = "identity_unlinked"
    MAIL_ADDRESS_CHANGED = "mail_address_changed"
    MAIL_ADDRESS_REMOVED = "mail_address_removed"
    TOKEN_MADE = "token_made"  # noqa: S105
    TOKEN_REVOKED = "token_revoked"  # noqa: S105
    RUN_PUBLISHED = "run_published"
    RUN_WITHDRAWN = "run_withdrawn"
    RUN_REVEALED = "run_revealed"  # the author of an anonymous one
    VERIFICATION_REQUESTED = "verification_requested"
    RUN_CANCELLED = "run_cancelled"  # by somebody else than its owner
    WORKER_DRAINED = "worker_drained"
    WORKER_RESUMED = "worker_resumed"
    REJUDGEMENT_STARTED = "rejudgement_started"
    REJUDGEMENT_ACCEPTED = "rejudgement_accepted"
    REJUDGEMENT_DISCARDED = "rejudgement_discarded"
    COMPETITION_CREATED = "competition_created"
    COMPETITION_OPENED = "competition_opened"
    COMPETITION_HANDED_OVER = "competition_handed_over"
    ROUND_MOVED = "round_moved"
    RETENTION_REQUESTED = "retention_requested"
    RETENTION_ENDED = "retention_ended"
    BACKUP_MADE = "backup_made"
    BACKUP_RESTORED = "backup_restored"

    @property
    def label(self) -> str:
        """The action in words."""
        return self.value.replace("sign_in", "sign-in").replace("_", " ").capitalize()


@dataclass(frozen=True, slots=True)
class Actor:
    """Who does something, and from which address; empty: unknown."""

    name: str
    address: str = ""


COMMAND_LINE = Actor("command line")  # no account has a name with a space
SERVICE = Actor("the service")


@dataclass(frozen=True, slots=True, kw_only=True)
class AuditFilter:
    """Which entries a page shows; an empty field does not filter."""

    action: str = ""
    actor: str = ""
    target: str = ""

    def conditions(self) -> list[ColumnElement[bool]]:
        """Return the conditions, each of which an index has."""
        wanted = {"actor": self.actor, "target": self.target, "action": self.action}
        return [getattr(AuditEntry, name) == value for name, value in wanted.items() if value]


@dataclass(frozen=True, slots=True)
class AuditPage:
    """Entries, newest first; `next` is where the following page begins, None at the end."""

    entries: Sequence[AuditEntry]
    next: int | None


def record(
    session: Session,
    actor: Actor,
    action: AuditAction,
    target: str = "",
    detail: Mapping[str, Any] | None = None,
) -> None:
    """Write an entry; the caller's transaction commits it.

    Parameters
    ----------
    target
        The name of an account, a worker or a competition, or "run 7".
    detail
        What else there is to know, never a secret.
    """
    entry = AuditEntry(at=time.time(), actor=actor.name[:80], address=actor.address[:64])
    entry.action, entry.target = action, target[:TARGET_MAX]
    entry.detail = dict(detail or {})
    session.add(entry)


def blocked_is_known(session: Session, actor: Actor, target: str) -> bool:
    """Return whether blocked sign-ins need no entry: there is one of this hour, or are too many."""
    recent = AuditEntry.at > time.time() - _HOUR_S
    blocked = (recent, AuditEntry.action == AuditAction.SIGN_IN_BLOCKED)
    same = (AuditEntry.target == target, AuditEntry.address == actor.address)
    if session.scalar(select(AuditEntry.id).where(*blocked, *same).limit(1)) is not None:
        return True
    count = select(func.count()).select_from(AuditEntry).where(*blocked)
    return (session.scalar(count) or 0) >= BLOCKED_PER_HOUR


def page(
    session: Session, wanted: AuditFilter, *, after: int | None = None, limit: int = PAGE
) -> AuditPage:
    """Return entries before the entry `after`, newest first.

    With several filters a page may be short or empty and yet have a next one.
    """
    limit = max(1, min(limit, PAGE_MAX))
    first, *others = wanted.conditions() or [AuditEntry.id > 0]
    window = select(AuditEntry.id).where(first).order_by(AuditEntry.id.desc())
    if after is not None:
        window = window.where(AuditEntry.id < after)
    seen = session.scalars(window.limit(SEEN_MAX if others else limit + 1)).all()
    query = select(AuditEntry).where(AuditEntry.id.in_(seen), *others)
    rows = session.scalars(query.order_by(AuditEntry.id.desc()).limit(limit + 1)).all()
    following = rows[limit - 1].id if len(rows) > limit else None
    if following is None and others and len(seen) == SEEN_MAX:
        following = seen[-1]
    return AuditPage(rows[:limit], following)


def as_dict(entry: AuditEntry) -> dict[str, Any]:
    """Return an entry as the API and the command line show it."""
    names = ("id", "at", "actor", "address", "action", "target", "detail")
    return {name: getattr(entry, name) for name in names}


def forget_old(session: Session, days: int) -> int:
    """Delete entries older than `days`, at most `BATCH`; return how many."""
    old = select(AuditEntry.id).where(AuditEntry.at < time.time() - days * _DAY_S)
    ids = session.scalars(old.order_by(AuditEntry.at).limit(BATCH)).all()
    session.execute(delete(AuditEntry).where(AuditEntry.id.in_(ids)))
    return len(ids)
