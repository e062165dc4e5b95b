"""What stands before every call: who asks, and which run is meant."""

from __future__ import annotations

from flask import Response, g, request

from seamark.server.accounts.permissions import ADMIN, READ, SUBMIT, Action, Viewer, can
from seamark.server.runs import door as runs
from seamark.server.runs.views import RunView
from seamark.server.web.problems import Problem
from seamark.server.web.services import services

_GONE = "There is no run {}, or it is private and belongs to somebody else."
# Asking for one of these tells no more than looking at the run did.
_ABOUT_LOOKING = frozenset({Action.VIEW, Action.VIEW_LOG, Action.VIEW_PROGRAM})


def viewer() -> Viewer:
    """Return who asks."""
    asking: Viewer = g.viewer
    return asking


def conditional(answer: Response) -> Response:
    """Return 304 without a body if the client has this very answer already."""
    answer.headers["Vary"] = "Authorization, Cookie"
    answer.make_conditional(request)
    return answer


def need_scope(scope: str) -> None:
    """Refuse a token that lacks the scope; cookies have all."""
    if scope not in viewer().scopes:
        raise Problem("scope-missing", f"This call needs the scope {scope}.")


def need_user() -> int:
    """Return the account's id; refuse guests and strangers."""
    user_id = viewer().user_id
    if user_id is None:
        raise Problem("unauthenticated", "This call needs an account: sign in, or send a token.")
    return user_id


def run_for(run_id: int, action: Action = Action.VIEW) -> RunView:
    """Return the run if the viewer may do `action` to it.

    Raises
    ------
    Problem
        not-found if it must not be seen, scope-missing or forbidden if it must not be changed.
    """
    with services().database.reading() as database:
        view = runs.show(database, run_id, services().settings)
    if view is None or not _knows(view):
        raise Problem("not-found", _GONE.format(run_id))
    if not can(viewer(), action, view):
        raise _refusal(action)
    return view


def _knows(view: RunView) -> bool:
    """Return whether the run's existence may be admitted, whatever the token's scopes are."""
    asking = viewer()
    if can(asking, Action.VIEW, view):
        return True
    whole = Viewer(
        user_id=asking.user_id, name=asking.name, is_admin=asking.is_admin, guest=asking.guest
    )
    limited = whole.scopes != asking.scopes
    is_own = view.user_id is not None and view.user_id == asking.user_id
    return limited and is_own and can(whole, Action.VIEW, view)


def _refusal(action: Action) -> Problem:
    needed = READ if action in _ABOUT_LOOKING else SUBMIT
    if needed not in viewer().scopes:
        return Problem("scope-missing", f"This call needs the scope {needed}.")
    if action is Action.PUBLISH and viewer().user_id is None:
        return Problem("account-needed", "Publishing needs an account: it shows your name.")
    return Problem("forbidden", f"Only the owner may {action.value} this run.")


def is_operator() -> bool:
    """Return whether the viewer is an admin who uses these rights now."""
    return viewer().is_admin and ADMIN in viewer().scopes
