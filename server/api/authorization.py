"""Authorization of API requests: the viewer, token scopes, and which run they may access."""

from __future__ import annotations

from dataclasses import replace

from flask import g

from seamark.server.accounts.permissions import (
    ADMIN,
    SCOPES,
    Action,
    Viewer,
    can,
    required_scope,
)
from seamark.server.runs import views
from seamark.server.runs.views import RunView
from seamark.server.web.problems import Problem
from seamark.server.web.services import services

_NOT_FOUND = "There is no run {}, or it is private and belongs to someone else."


def viewer() -> Viewer:
    """Return who sent the request."""
    current: Viewer = g.viewer
    return current


def require_scope(scope: str) -> None:
    """Refuse a token without the scope; cookies have all scopes."""
    if scope not in viewer().scopes:
        raise Problem("scope-missing", f"This call requires the scope {scope}.")


def require_account() -> int:
    """Return the account's id; refuse guests and anonymous clients."""
    user_id = viewer().user_id
    if user_id is None:
        raise Problem("unauthenticated", "This call requires an account: sign in or send a token.")
    return user_id


def run_for(run_id: int, action: Action = Action.VIEW) -> RunView:
    """Return the run if the viewer may perform `action` on it.

    Raises
    ------
    Problem
        not-found if the viewer may not know of the run; otherwise scope-missing, account-needed
        or forbidden if the action is not permitted.
    """
    with services().database.reading() as database:
        run = views.show(database, run_id, services().settings)
    if run is None or not _may_know_of(run):
        raise Problem("not-found", _NOT_FOUND.format(run_id))
    if not can(viewer(), action, run):
        raise _refusal(action)
    return run


def is_operator() -> bool:
    """Return whether the viewer is an admin whose token or cookie has the admin scope."""
    return viewer().is_admin and ADMIN in viewer().scopes


def _may_know_of(run: RunView) -> bool:
    """Return whether the viewer could see the run if the token had all scopes.

    A token without the scope "read" gets scope-missing for its owner's runs, not not-found.
    """
    if can(viewer(), Action.VIEW, run):
        return True
    is_own = run.user_id is not None and run.user_id == viewer().user_id
    return is_own and can(replace(viewer(), scopes=frozenset(SCOPES)), Action.VIEW, run)


def _refusal(action: Action) -> Problem:
    scope = required_scope(action)
    if scope not in viewer().scopes:
        return Problem("scope-missing", f"This call requires the scope {scope}.")
    if action is Action.PUBLISH and viewer().user_id is None:
        return Problem("account-needed", "Publishing requires an account: it shows your name.")
    return Problem("forbidden", f"Only the owner may {action.value} this run.")
