"""What changes a run: cancel, publish, withdraw. Never by GET."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import structlog
from flask_openapi3.blueprint import APIBlueprint
from flask_openapi3.models.tag import Tag
from redis.exceptions import RedisError
from sqlalchemy.orm import Session

from seamark.server.accounts.permissions import Action
from seamark.server.api import authorization
from seamark.server.api.schemas import RunPath, RunResponse, run_answer
from seamark.server.messaging import live_events
from seamark.server.runs import results, views
from seamark.server.runs.states import RunState
from seamark.server.runs.views import RunView
from seamark.server.web.problems import Problem
from seamark.server.web.services import services

api = APIBlueprint(
    "api_actions",
    __name__,
    url_prefix="/api/v1",
    abp_tags=[Tag(name="Runs", description="Submit runs and follow them.")],
)
_log = structlog.get_logger()


@api.post("/runs/<int:run_id>/cancel", responses={200: RunResponse})
def cancel(path: RunPath) -> dict[str, Any]:
    """Cancel a run that waits or runs. What it recorded so far stays."""
    before = authorization.run_for(path.run_id, Action.CANCEL)
    after = _change(path.run_id, results.cancel, f"It is {before.state.value} already.")
    if before.state is RunState.QUEUED:
        _tell_listeners(path.run_id)
    return run_answer(after)


@api.post("/runs/<int:run_id>/publish", responses={200: RunResponse})
def publish(path: RunPath) -> dict[str, Any]:
    """Make a run that has ended public; a ranked one enters the leaderboard."""
    before = authorization.run_for(path.run_id, Action.PUBLISH)
    why = (
        "It is public already." if before.public else "Only a run that has ended can be published."
    )
    return run_answer(_change(path.run_id, results.publish, why))


@api.post("/runs/<int:run_id>/withdraw", responses={200: RunResponse})
def withdraw(path: RunPath) -> dict[str, Any]:
    """Make a public run private again and take it off the leaderboard."""
    authorization.run_for(path.run_id, Action.WITHDRAW)
    return run_answer(_change(path.run_id, results.withdraw, "It is not public."))


def _change(run_id: int, change: Callable[[Session, int], bool], why_not: str) -> RunView:
    with services().database.writing() as database:
        if not change(database, run_id):
            raise Problem("conflict", why_not)
    with services().database.reading() as database:
        view = views.show(database, run_id, services().settings)
    if view is None:
        raise Problem("not-found")
    return view


def _tell_listeners(run_id: int) -> None:
    """End the live streams of a run that no worker has taken, so that nobody else will."""
    state = {"state": RunState.CANCELLED.value, "position": None, "progress": 0, "t_simulated": 0}
    try:
        live_events.append(services().redis, run_id, live_events.STATE, state)
        live_events.append(services().redis, run_id, live_events.END, {})
    except RedisError as error:  # streams look at the database too, only later
        _log.warning("tell_failed", run=run_id, error=str(error))
