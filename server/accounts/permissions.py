"""Permissions: the only place that decides who may do what."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Protocol

READ, SUBMIT, ADMIN = "read", "submit", "admin"
SCOPES: tuple[str, ...] = (READ, SUBMIT, ADMIN)


class Action(StrEnum):
    """What a viewer may do; the second group applies to one run."""

    SUBMIT = "submit"
    UPLOAD = "upload"
    SUBMIT_RANKED = "submit_ranked"
    MANAGE_ACCOUNT = "manage_account"
    ADMINISTER = "administer"

    VIEW = "view"
    VIEW_PROGRAM = "view_program"
    VIEW_LOG = "view_log"
    CANCEL = "cancel"
    PUBLISH = "publish"
    WITHDRAW = "withdraw"
    RERUN = "rerun"


@dataclass(frozen=True, slots=True, kw_only=True)
class Viewer:
    """Who sent a request: a user, a guest identified by a cookie, or an anonymous visitor."""

    user_id: int | None = None
    name: str = ""
    is_admin: bool = False
    guest: str | None = None  # hash of the cookie
    scopes: frozenset[str] = frozenset(SCOPES)  # fewer for a token

    @property
    def owner(self) -> str | None:
        """The key under which this viewer's runs are queued and counted; None if anonymous."""
        if self.user_id is not None:
            return f"user:{self.user_id}"
        return None if self.guest is None else f"guest:{self.guest}"


class Owned(Protocol):
    """What `can` needs to know about a run; tables.Run and RunView provide it."""

    @property
    def user_id(self) -> int | None: ...  # noqa: D102 - the attribute of tables.Run
    @property
    def guest(self) -> str | None: ...  # noqa: D102
    @property
    def public(self) -> bool: ...  # noqa: D102


_NEEDS_USER = {Action.UPLOAD, Action.SUBMIT_RANKED, Action.MANAGE_ACCOUNT}
_READS = {Action.VIEW, Action.VIEW_PROGRAM, Action.VIEW_LOG}


def required_scope(action: Action) -> str:
    """Return the scope that a token needs for an action."""
    if action is Action.ADMINISTER:
        return ADMIN
    return READ if action in _READS else SUBMIT


def can(viewer: Viewer, action: Action, run: Owned | None = None) -> bool:
    """Return whether `viewer` may perform `action`, on `run` if it applies to a run."""
    if action is Action.ADMINISTER:
        return viewer.is_admin and ADMIN in viewer.scopes
    if run is not None and run.public and action in _READS:
        return True
    if viewer.owner is None or required_scope(action) not in viewer.scopes:
        return False
    if action in _NEEDS_USER:
        return viewer.user_id is not None
    if action is Action.SUBMIT:
        return True
    return run is not None and _may_on_run(viewer, action, run)


def _may_on_run(viewer: Viewer, action: Action, run: Owned) -> bool:
    """Decide for a private run, or for an action other than reading."""
    if action is Action.PUBLISH and viewer.user_id is None:
        return False  # a guest has no name to publish under
    if owns(viewer, run):
        return True
    if action is Action.RERUN:
        return run.public
    return viewer.is_admin and ADMIN in viewer.scopes


def owns(viewer: Viewer, run: Owned) -> bool:
    """Return whether the run is the viewer's own."""
    if run.user_id is not None:
        return run.user_id == viewer.user_id
    return run.guest is not None and viewer.user_id is None and run.guest == viewer.guest
