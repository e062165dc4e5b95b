"""A run's events as they happen (server-sent events), and again for a run that has ended."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from typing import Any

from flask import Response, request
from flask_openapi3.blueprint import APIBlueprint
from flask_openapi3.models.tag import Tag

from seamark.server.accounts.permissions import Action, can
from seamark.server.api import authorization
from seamark.server.api.schemas import RunPath
from seamark.server.messaging import live_events
from seamark.server.messaging.live_events import Event
from seamark.server.runs import views
from seamark.server.runs.files import RunFiles
from seamark.server.runs.views import RunView
from seamark.server.web.problems import Problem
from seamark.server.web.services import Services, services

RECONNECT_MS = 2000  # how long a browser waits before it asks again
FULL_RETRY_S = 10
REPLAY_ROWS = 400  # telemetry rows of a replay, at most; the whole of it is in telemetry.csv
BATCH_ROWS = 50

api = APIBlueprint(
    "api_events",
    __name__,
    url_prefix="/api/v1",
    abp_tags=[Tag(name="Runs", description="Submit runs and follow them.")],
)
_STREAM: Any = {200: {"content": {"text/event-stream": {"schema": {"type": "string"}}}}}


@api.get("/runs/<int:run_id>/events", responses=_STREAM)
def stream(path: RunPath) -> Response:
    """Follow a run by server-sent events: state, telemetry, log, end.

    Goes on after the header Last-Event-ID. A run that has ended is told again.
    """
    view = authorization.run_for(path.run_id)
    held = services()
    if request.method == "HEAD":
        return _response(iter(()))
    if view.state.final:
        return _response(_told_again(held, view, request.headers.get("Last-Event-ID")))
    if held.fanout.open_streams >= held.settings.streams_max:
        raise Problem("streams-full", headers={"Retry-After": str(FULL_RETRY_S)})
    shows_log = can(authorization.viewer(), Action.VIEW_LOG, view)
    events = _as_it_happens(held, view, request.headers.get("Last-Event-ID"))
    return _response(event for event in events if shows_log or event.kind != live_events.LOG)


def _response(events: Iterator[Event]) -> Response:
    answer = Response(_texts(events), content_type="text/event-stream; charset=utf-8")
    answer.headers["Cache-Control"] = "no-store"
    answer.headers["X-Accel-Buffering"] = "no"  # nginx must not collect events
    return answer


def _texts(events: Iterator[Event]) -> Iterator[str]:
    yield f"retry: {RECONNECT_MS}\n\n"
    for event in events:
        yield event.sse() if event.id or event.kind == live_events.HEARTBEAT else _without_id(event)


def _without_id(event: Event) -> str:
    """Return an event that is not a place to go on from."""
    return f"event: {event.kind}\ndata: {json.dumps(event.data)}\n\n"


def _state(view: RunView) -> Event:
    names = ("position", "progress", "t_simulated", "cause")
    data: dict[str, Any] = {name: getattr(view, name) for name in names}
    return Event("", live_events.STATE, {"state": view.state.value, **data})


def _as_it_happens(held: Services, view: RunView, last_id: str | None) -> Iterator[Event]:
    """Yield events until the run has ended; holds no session of the database between them."""
    yield _state(view)
    try:
        # Here and not in the route: a response that is never iterated would keep its place.
        events = held.fanout.subscribe(view.id, last_id)
    except live_events.TooManyStreams:
        return  # the browser asks again after RECONNECT_MS
    for event in events:
        yield event
        if event.kind == live_events.HEARTBEAT:
            now = _look(held, view.id)
            yield _state(now or view)
            if now is None or now.state.final:  # its worker died, nobody else sends the end
                yield Event("", live_events.END, {})
                return


def _look(held: Services, run_id: int) -> RunView | None:
    with held.database.reading() as database:
        return views.show(database, run_id, held.settings)


def _told_again(held: Services, view: RunView, last_id: str | None) -> Iterator[Event]:
    """Yield what is still in the broker after `last_id`, else a replay from the files."""
    kept = live_events.history(held.redis, view.id, last_id)
    if last_id is None and not _is_whole(kept):
        yield from _from_files(held, view)
    else:
        yield from (event for event in kept if event.kind != live_events.END)
    yield _state(view)
    yield Event("", live_events.END, {})


def _is_whole(events: list[Event]) -> bool:
    """Return whether the stream was not cut at its start: the first rows are the first rows."""
    rows = [event for event in events if event.kind == live_events.TELEMETRY]
    if not rows or not rows[0].data.get("rows"):
        return False
    columns = list(rows[0].data["columns"])
    return "t" in columns and rows[0].data["rows"][0][columns.index("t")] < 1.0


def _from_files(held: Services, view: RunView) -> Iterator[Event]:
    files = RunFiles(held.settings.data, view.id)
    total = files.row_count()
    step = max(total // REPLAY_ROWS, 1)
    for start in range(0, total, step * BATCH_ROWS):
        rows = files.rows(start, min(start + step * BATCH_ROWS, total))[::step].tolist()
        finite = [[v if math.isfinite(v) else None for v in row] for row in rows]
        data = {"columns": list(files.columns), "rows": finite}
        yield Event("", live_events.TELEMETRY, data)
    if text := files.log_text():
        yield Event("", live_events.LOG, {"text": text})
