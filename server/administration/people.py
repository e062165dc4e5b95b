"""The accounts of people: finding them, role, quota, disabling, revoking, deleting."""

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import ColumnElement, delete, func, select
from sqlalchemy.orm import Session

from seamark.server.accounts import accounts, audit, password_resets
from seamark.server.accounts.accounts import AccountRejected
from seamark.server.accounts.audit import Actor, AuditAction
from seamark.server.accounts.permissions import Role, Viewer
from seamark.server.database.account_tables import AccountDeletion, PasswordReset
from seamark.server.database.tables import BrowserSession, Run, Token, User
from seamark.server.runs.ending import account_deletion, results
from seamark.server.runs.record.states import LIVE
from seamark.server.runs.submission import quota
from seamark.server.runs.submission.quota import Quota
from seamark.server.settings import Settings

PAGE, PAGE_MAX = 50, 200
SEARCH_MAX = accounts.NAME_MAX  # [character]
QUOTA_DAY_MAX = 100_000


@dataclass(frozen=True, slots=True, kw_only=True)
class PersonFilter:
    """Which accounts a list shows; a field that is left out does not filter."""

    text: str = ""  # part of the name
    role: Role | None = None
    disabled: bool = False  # only these

    def conditions(self) -> list[ColumnElement[bool]]:
        """Return the conditions on `User`."""
        conditions: list[ColumnElement[bool]] = [
            User.is_baseline.is_(False),
            User.id.not_in(select(AccountDeletion.user_id)),
        ]
        if self.text:
            conditions.append(User.name_key.contains(self.text.casefold(), autoescape=True))
        if self.role is not None:
            conditions.append(User.role == self.role.label)
        if self.disabled:
            conditions.append(User.disabled_at.is_not(None))
        return conditions


@dataclass(frozen=True, slots=True)
class PersonPage:
    """Accounts, newest first; `next` is where the following page begins, None at the end."""

    people: Sequence[User]
    next: int | None


@dataclass(frozen=True, slots=True, kw_only=True)
class PersonDetail:
    """What an admin sees of one account."""

    user: User
    used: Quota
    browsers: int
    tokens: int
    token_used_at: float | None  # the last time, of any of them
    live_runs: Sequence[int]


def page(
    session: Session, wanted: PersonFilter, *, after: int | None = None, limit: int = PAGE
) -> PersonPage:
    """Return the accounts made before the account `after`, newest first."""
    limit = max(1, min(limit, PAGE_MAX))
    query = select(User).where(*wanted.conditions()).order_by(User.id.desc())
    if after is not None:
        query = query.where(User.id < after)
    rows = session.scalars(query.limit(limit + 1)).all()
    return PersonPage(rows[:limit], rows[limit - 1].id if len(rows) > limit else None)


def find(session: Session, user_id: int) -> User | None:
    """Return an account of a person; None if there is none or it is being deleted."""
    return session.scalar(select(User).where(User.id == user_id, *PersonFilter().conditions()))


def detail(session: Session, user: User, settings: Settings) -> PersonDetail:
    """Return what an admin sees of an account."""
    browsers = (BrowserSession.user_id == user.id, BrowserSession.expires_at > time.time())
    tokens = select(func.count(), func.max(Token.last_used_at)).where(Token.user_id == user.id)
    count, used_at = session.execute(tokens).one()
    return PersonDetail(
        user=user,
        used=quota.used_by(session, Viewer(user_id=user.id), settings),
        browsers=session.scalar(select(func.count()).where(*browsers)) or 0,
        tokens=count,
        token_used_at=used_at,
        live_runs=_live_runs(session, user.id),
    )


def set_role(session: Session, actor: Actor, user: User, role: Role) -> None:
    """Give an account another role; raises AccountRejected for the admin's own."""
    _refuse_own(actor, user, "change the role of")
    if user.role != role.label:
        change = {"from": user.role, "to": role.label}
        audit.record(session, actor, AuditAction.ROLE_CHANGED, user.name, change)
        user.role = role.label


def set_quota_day(session: Session, actor: Actor, user: User, quota_day: int | None) -> None:
    """Set how many runs a user may complete in 24 h; None: as many as the setting says."""
    if quota_day is not None and not 0 <= quota_day <= QUOTA_DAY_MAX:
        raise AccountRejected(f"Runs in 24 hours: a number from 0 to {QUOTA_DAY_MAX}.")
    if user.quota_day != quota_day:
        change = {"from": user.quota_day, "to": quota_day}
        audit.record(session, actor, AuditAction.QUOTA_CHANGED, user.name, change)
        user.quota_day = quota_day


def disable(session: Session, actor: Actor, user: User) -> None:
    """Refuse an account everywhere: no sign-in, browsers and tokens are refused at once.

    Its queued and running runs are cancelled: they would occupy slots that others wait for. What
    running ones have recorded is kept. Browsers and tokens work again when it is enabled.

    Raises
    ------
    AccountRejected
        It is the admin's own account.
    """
    _refuse_own(actor, user, "disable")
    if user.disabled_at is None:
        user.disabled_at = time.time()
        session.execute(delete(PasswordReset).where(PasswordReset.user_id == user.id))
        cancelled = [run for run in _live_runs(session, user.id) if results.cancel(session, run)]
        cause = {"cancelled_runs": len(cancelled)}
        audit.record(session, actor, AuditAction.ACCOUNT_DISABLED, user.name, cause)


def enable(session: Session, actor: Actor, user: User) -> None:
    """Let a disabled account sign in again."""
    if user.disabled_at is not None:
        user.disabled_at = None
        audit.record(session, actor, AuditAction.ACCOUNT_ENABLED, user.name)


def revoke_access(session: Session, actor: Actor, user: User) -> None:
    """Sign out all browsers of an account and revoke all its tokens."""
    accounts.revoke_access(session, user.id)
    audit.record(session, actor, AuditAction.ACCESS_REVOKED, user.name)


def make_reset_link(session: Session, actor: Actor, user: User) -> str:
    """Return the secret of a link for a new password; raises AccountRejected if disabled."""
    text = password_resets.create(session, user.name)
    audit.record(session, actor, AuditAction.RESET_LINK_MADE, user.name)
    return text


def close(session: Session, actor: Actor, user: User, *, keep_published: bool) -> None:
    """Delete an account; the workers then delete its runs. Raises AccountRejected for one's own."""
    _refuse_own(actor, user, "delete")
    kept = {"keep_published": keep_published}
    audit.record(session, actor, AuditAction.ACCOUNT_DELETED, user.name, kept)
    account_deletion.close(session, user.id, keep_published=keep_published)


def apply(session: Session, actor: Actor, user: User, changes: Mapping[str, Any]) -> None:
    """Change `role`, `quota_day` or `disabled` of an account, all or none of them.

    Raises
    ------
    AccountRejected
        A number is out of range, or it is the admin's own account.
    """
    if "quota_day" in changes:
        set_quota_day(session, actor, user, changes["quota_day"])
    if changes.get("role") is not None:
        set_role(session, actor, user, Role[changes["role"].upper()])
    if changes.get("disabled") is not None:
        (disable if changes["disabled"] else enable)(session, actor, user)


def _live_runs(session: Session, user_id: int) -> Sequence[int]:
    own = Run.owner == (Viewer(user_id=user_id).owner or "")
    return session.scalars(select(Run.id).where(own, Run.state.in_(LIVE)).order_by(Run.id)).all()


def _refuse_own(actor: Actor, user: User, what: str) -> None:
    """Admins who lock their own account could lock everybody out of the administration."""
    if actor.name == user.name:
        raise AccountRejected(f"You cannot {what} your own account here.")
