"""The events of a run as server-sent events: live, or replayed if it has ended."""

from __future__ import annotations

from collections.abc import AsyncGenerator, Iterable
from functools import lru_cache
from pathlib import Path
from typing import Any

from flask import Response, request
from flask_openapi3.blueprint import APIBlueprint
from flask_openapi3.models.tag import Tag

from seamark.server.accounts.permissions import Action, can
from seamark.server.api.requests.operation_ids import operation_id
from seamark.server.api.requests.schemas import EventsQuery, RunPath
from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.showing.views import RunView
from seamark.server.web import access, authentication
from seamark.server.web.asgi import CONTINUATION, Connection
from seamark.server.web.problems import Problem
from seamark.server.web.services import services
from seamark.server.web.streams import events
from seamark.server.web.streams.events import LOG, Position
from seamark.server.web.streams.excerpts import START, Excerpt, excerpt, position_now
from seamark.server.web.streams.feed import state_values

FULL_RETRY_S = 10
REPLAYS_KEPT = 32  # of 50 KB at most

api = APIBlueprint(
    "api_events",
    __name__,
    url_prefix="/api/v1",
    operation_id_callback=operation_id,
    abp_tags=[Tag(name="Runs", description="Submit runs and follow them.")],
)
# Of each event, as OpenAPI 3.1 is read for event streams (3.2 has `itemSchema` for it).
_EVENT: dict[str, Any] = {
    "type": "object",
    "properties": {
        "event": {"enum": [events.STATE, events.TELEMETRY, events.LOG, events.END]},
        "data": {"type": "string", "contentMediaType": "application/json"},
        "id": {"type": "string", "description": "To be sent as Last-Event-ID to continue"},
        "retry": {"type": "integer", "description": "Milliseconds until a client reconnects"},
    },
}
_STREAM: Any = {200: {"content": {"text/event-stream": {"schema": _EVENT}}}}


@api.get("/runs/<int:run_id>/events", responses=_STREAM)
def stream(path: RunPath, query: EventsQuery) -> Response:
    """Follow a run by server-sent events, at most 50 KB to begin with and 20 KB/s afterwards.

    - `state`: `state`, `progress`, `t_simulated`, `position` in the queue, `cause` of a failure,
      `viewers` who follow a live run
    - `telemetry`: `columns` and `rows`, thinned to what a screen shows, five digits;
      telemetry.csv has all rows
    - `log`: `text` that the program printed; `gap` is true if output before it was left out
    - `end`: nothing follows

    Starts with the newest trial; one that has ended is replayed as a whole. The id of an event is
    `attempt-row-byte`: after the header Last-Event-ID, or without it after the parameter `after`,
    follows what came since. The stream of a token or browser that is refused by now ends within
    seconds.
    """
    run = access.run_for(path.run_id)
    after = Position.parse(request.headers.get("Last-Event-ID") or query.after)
    shows_log = can(access.viewer(), Action.VIEW_LOG, run)
    if request.method == "HEAD":
        return _response(())
    if run.state.final:
        files = access.files_of(run)
        replayed = _replay(files.root, run.data_id, after, position_now(files), files.hidden)
        return _response(_frames(run, replayed, shows_log=shows_log))
    if services().streams.full:
        raise Problem("streams-full", headers={"Retry-After": str(FULL_RETRY_S)})
    # An iterator: of a sequence the length would be known, and nothing could follow.
    greeting = (events.greeting(), _state(run, services().streams.viewers(run.id) + 1))
    response = _response(iter(greeting))
    request.environ[CONTINUATION] = _follower(run.id, after, shows_log=shows_log)
    return response


def _response(data: Iterable[bytes]) -> Response:
    answer = Response(data, content_type="text/event-stream; charset=utf-8")
    answer.headers["Cache-Control"] = "no-store"
    answer.headers["X-Accel-Buffering"] = "no"  # nginx must not buffer events
    return answer


def _follower(run_id: int, after: Position | None, *, shows_log: bool) -> Any:
    """Return what continues the response on the event loop."""
    hub, credential = services().streams, authentication.credential()

    def follow(connection: Connection) -> AsyncGenerator[bytes, None]:
        return hub.follow(
            run_id,
            after,
            shows_log=shows_log,
            credential=credential,
            gone=connection.gone,
            abort=connection.abort,
        )

    return follow


def _frames(run: RunView, replayed: Excerpt, *, shows_log: bool) -> list[bytes]:
    shown = [frame.data for frame in replayed.frames if shows_log or frame.type != LOG]
    return [events.greeting(), *shown, _state(run, viewers=0), events.end().data]


def _state(run: RunView, viewers: int) -> bytes:
    return events.state(state_values(run, viewers=viewers)).data


@lru_cache(maxsize=REPLAYS_KEPT)
def _replay(
    root: Path, run_id: int, after: Position | None, until: Position, hidden: tuple[str, ...]
) -> Excerpt:
    """Return what a run that has ended recorded between two positions."""
    files = RunFiles(root.parents[2], run_id, until.attempt)
    files.hidden = hidden
    return excerpt(files, after or Position(until.attempt, 0, 0), until, START)
