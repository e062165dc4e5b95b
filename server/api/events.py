"""The events of a run as server-sent events: live, or replayed if it has ended."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from typing import Any

from flask import Response, request
from flask_openapi3.blueprint import APIBlueprint
from flask_openapi3.models.tag import Tag

from seamark.server.accounts.permissions import Action, can
from seamark.server.api.schemas import RunPath
from seamark.server.messaging import live_events
from seamark.server.messaging.live_events import Event
from seamark.server.runs import views
from seamark.server.runs.files import RunFiles
from seamark.server.runs.views import RunView
from seamark.server.web import access
from seamark.server.web.problems import Problem
from seamark.server.web.services import Services, services

RECONNECT_MS = 2000  # how long a browser waits before it reconnects
FULL_RETRY_S = 10
REPLAY_ROWS = 400  # telemetry rows of a replay at most; telemetry.csv has all
BATCH_ROWS = 50

api = APIBlueprint(
    "api_events",
    __name__,
    url_prefix="/api/v1",
    abp_tags=[Tag(name="Runs", description="Submit runs and follow them.")],
)
# Of each event, as OpenAPI 3.1 is read for event streams (3.2 has `itemSchema` for it).
_EVENT: dict[str, Any] = {
    "type": "object",
    "properties": {
        "event": {
            "enum": [live_events.STATE, live_events.TELEMETRY, live_events.LOG, live_events.END]
        },
        "data": {"type": "string", "contentMediaType": "application/json"},
        "id": {"type": "string", "description": "To be sent as Last-Event-ID to continue"},
        "retry": {"type": "integer", "description": "Milliseconds until a client reconnects"},
    },
}
_STREAM: Any = {200: {"content": {"text/event-stream": {"schema": _EVENT}}}}


@api.get("/runs/<int:run_id>/events", responses=_STREAM)
def stream(path: RunPath) -> Response:
    """Follow a run by server-sent events: state, telemetry, log, end.

    Continues after the header Last-Event-ID. A run that has ended is replayed.
    """
    run, app_services = access.run_for(path.run_id), services()
    last_id = request.headers.get("Last-Event-ID")
    if request.method == "HEAD":
        return _response(iter(()))
    if run.state.final:
        events = _replayed(app_services, run, last_id)
    elif app_services.fanout.open_streams < app_services.settings.streams_max:
        events = _live(app_services, run, last_id)
    else:
        raise Problem("streams-full", headers={"Retry-After": str(FULL_RETRY_S)})
    shows_log = can(access.viewer(), Action.VIEW_LOG, run)
    return _response(event for event in events if shows_log or event.type != live_events.LOG)


def _response(events: Iterator[Event]) -> Response:
    answer = Response(_texts(events), content_type="text/event-stream; charset=utf-8")
    answer.headers["Cache-Control"] = "no-store"
    answer.headers["X-Accel-Buffering"] = "no"  # nginx must not buffer events
    return answer


def _texts(events: Iterator[Event]) -> Iterator[str]:
    yield f"retry: {RECONNECT_MS}\n\n"
    for event in events:
        yield event.sse() if event.id or event.type == live_events.HEARTBEAT else _without_id(event)


def _without_id(event: Event) -> str:
    """Return an event after which a client cannot resume."""
    return f"event: {event.type}\ndata: {json.dumps(event.data)}\n\n"


def _state(view: RunView) -> Event:
    names = ("position", "progress", "t_simulated", "cause")
    data: dict[str, Any] = {name: getattr(view, name) for name in names}
    return Event("", live_events.STATE, {"state": view.state.value, **data})


def _live(app_services: Services, view: RunView, last_id: str | None) -> Iterator[Event]:
    """Yield events until the run has ended; holds no database session between them."""
    yield _state(view)
    try:
        # Not in the route: a response that is never iterated would never be unsubscribed.
        events = app_services.fanout.subscribe(view.id, last_id)
    except live_events.TooManyStreams:
        return  # the browser reconnects after RECONNECT_MS
    for event in events:
        yield event
        if event.type == live_events.HEARTBEAT:
            now = _show(app_services, view.id)
            yield _state(now or view)
            if now is None or now.state.final:  # its worker died, so that no "end" was published
                yield Event("", live_events.END, {})
                return


def _show(app_services: Services, run_id: int) -> RunView | None:
    with app_services.database.reading() as database:
        return views.show(database, run_id, app_services.settings)


def _replayed(app_services: Services, view: RunView, last_id: str | None) -> Iterator[Event]:
    """Yield the events that the broker still has after `last_id`, else a replay from the files."""
    events = live_events.history(app_services.redis, view.id, last_id)
    if last_id is None and not _is_complete(events):
        yield from _from_files(app_services, view)
    else:
        yield from (event for event in events if event.type != live_events.END)
    yield _state(view)
    yield Event("", live_events.END, {})


def _is_complete(events: list[Event]) -> bool:
    """Return whether the stream still has its start: its first row is at the start of a trial."""
    rows = [event for event in events if event.type == live_events.TELEMETRY]
    if not rows or not rows[0].data.get("rows"):
        return False
    columns = list(rows[0].data["columns"])
    return "t" in columns and rows[0].data["rows"][0][columns.index("t")] < 1.0


def _from_files(app_services: Services, view: RunView) -> Iterator[Event]:
    files = RunFiles(app_services.settings.data, view.id)
    total = files.row_count()
    step = max(total // REPLAY_ROWS, 1)
    for start in range(0, total, step * BATCH_ROWS):
        rows = files.rows(start, min(start + step * BATCH_ROWS, total))[::step].tolist()
        finite = [[v if math.isfinite(v) else None for v in row] for row in rows]
        data = {"columns": list(files.columns), "rows": finite}
        yield Event("", live_events.TELEMETRY, data)
    if text := files.log_text():
        yield Event("", live_events.LOG, {"text": text})
