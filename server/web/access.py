"""Access of the current request: what it may do, and to which run; for pages and the API alike.

A refusal is a `Problem`: a document for programs, a page for people.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from datetime import UTC, datetime
from typing import Any

from flask import g
from sqlalchemy.orm import Session

from seamark.server.accounts import audit
from seamark.server.accounts.audit import AuditAction
from seamark.server.accounts.permissions import READ, RULES, Action, Owned, Role, Viewer, can, owns
from seamark.server.runs.data import stored_files
from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.showing import views
from seamark.server.runs.showing.views import RunView
from seamark.server.runs.submission import sweeps
from seamark.server.runs.submission.sweeps import SweepView
from seamark.server.storage import storage
from seamark.server.web import client_network
from seamark.server.web.problems import Problem
from seamark.server.web.services import services

_NOT_FOUND = "There is no run {}, or it is private and belongs to someone else."


def viewer() -> Viewer:
    """Return who sent the request."""
    current: Viewer = g.viewer
    return current


def actor() -> audit.Actor:
    """Return who sent the request, as the audit log names them."""
    name = viewer().name or viewer().role.label
    return audit.Actor(name, client_network.address().removesuffix("/32"))


def not_owner(run: Owned) -> audit.Actor | None:
    """Return who sent the request, if the run is somebody else's."""
    return None if owns(viewer(), run) else actor()


def record(
    session: Session, action: AuditAction, target: str, detail: Mapping[str, Any] | None = None
) -> None:
    """Write into the audit log what the sender of the request does."""
    audit.record(session, actor(), action, target, detail)


def require_scope(action: Action) -> None:
    """Refuse a token without the scope that an action needs; cookies have all scopes."""
    scope = RULES[action].scope
    if scope not in viewer().scopes:
        raise Problem("scope-missing", f"This call requires the scope {scope}.")


def require(action: Action) -> None:
    """Refuse a request whose sender may not perform an action that applies to no run."""
    if can(viewer(), action):
        return
    rule = RULES[action]
    if viewer().role < min(rule.role, Role.USER):
        raise Problem("unauthenticated", "This requires an account: sign in or send a token.")
    if viewer().role < rule.role:
        raise Problem("forbidden", f"This requires the role {rule.role.label}.")
    require_scope(action)
    raise Problem("forbidden", "This is only possible in a browser, not with a token.")


def require_account(action: Action) -> int:
    """Return the account's id; refuse who may not perform an action that needs an account."""
    require(action)
    user_id = viewer().user_id
    if user_id is None:
        raise Problem("unauthenticated")
    return user_id


def run_for(run_id: int, action: Action = Action.VIEW) -> RunView:
    """Return the run if the viewer may perform `action` on it.

    Raises
    ------
    Problem
        not-found if the viewer may not know of the run; otherwise scope-missing, account-needed
        or forbidden if the action is not permitted.
    """
    run = known_run(run_id)
    if not can(viewer(), action, run):
        raise _refusal(action)
    return run


def known_run(run_id: int) -> RunView:
    """Return the run if the viewer may know of it; it need not be shown.

    A token without the scope "read" may know of its owner's runs: it gets scope-missing for them,
    not not-found.
    """
    with services().database.reading() as database:
        run = views.show(database, run_id, services().settings)
    if run is None or not _may_know_of(run):
        raise Problem("not-found", _NOT_FOUND.format(run_id))
    return run


def sweep_for(sweep_id: int, action: Action = Action.VIEW) -> SweepView:
    """Return the sweep if the viewer may perform `action` on it; raises as `run_for`."""
    with services().database.reading() as database:
        sweep = sweeps.show(database, sweep_id)
    if sweep is None or not _may_know_of(sweep):
        raise Problem("not-found", f"There is no sweep {sweep_id}, or it belongs to someone else.")
    if not can(viewer(), action, sweep):
        raise _refusal(action)
    return sweep


def files_of(run: RunView) -> RunFiles:
    """Return the files of the latest attempt. Raises as `require_data`."""
    require_data(run)
    return stored_files.of_run(services().settings, run)


def require_data(run: RunView) -> None:
    """Refuse a request for data of a run that are not there.

    Raises
    ------
    StorageUnavailable
        The data folder is away.
    Problem
        data-deleted.
    """
    if run.data_deleted_at is not None:
        on = datetime.fromtimestamp(run.data_deleted_at, UTC).date()
        raise Problem("data-deleted", f"The data of run {run.id} was deleted on {on}.")
    storage.require_readable(services().settings)


def _may_know_of(run: Owned) -> bool:
    return can(replace(viewer(), scopes=viewer().scopes | {READ}), Action.VIEW, run)


def _refusal(action: Action) -> Problem:
    scope = RULES[action].scope
    if scope not in viewer().scopes:
        return Problem("scope-missing", f"This call requires the scope {scope}.")
    if action is Action.PUBLISH and viewer().user_id is None:
        return Problem("account-needed", "Publishing requires an account: it shows your name.")
    what = "delete the data of" if action is Action.DELETE_DATA else action.value
    return Problem("forbidden", f"Only the owner may {what} this run.")
