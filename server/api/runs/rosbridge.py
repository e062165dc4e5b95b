"""Programs that take part over the network: rosbridge on a WebSocket."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from typing import Annotated, Any

import structlog
from flask import Response, request
from flask_openapi3.blueprint import APIBlueprint
from flask_openapi3.models.tag import Tag
from pydantic import BaseModel, ConfigDict, Field, Json

from seamark.bridge.rosbridge.axes import Axes
from seamark.bridge.rosbridge.protocol import SetAxes
from seamark.server.accounts.permissions import Action
from seamark.server.api.requests import refusals
from seamark.server.api.requests.operation_ids import operation_id
from seamark.server.database.engine import DATABASE_AWAY
from seamark.server.runs.ending import cancellation
from seamark.server.runs.queue import queue
from seamark.server.runs.record.solutions import ROSBRIDGE
from seamark.server.runs.submission import submission, validation
from seamark.server.runs.submission.validation import Submission, ValidSubmission
from seamark.server.storage.storage import StorageUnavailable
from seamark.server.web import access, authentication, rate_limits
from seamark.server.web.problems import Problem
from seamark.server.web.services import Services, services
from seamark.server.web.streams.bridge_session import BUSY_RETRY_S, BridgeSession, SessionRefused
from seamark.server.web.websockets import CONVERSATION, UPGRADE, NotAllowed, WebSocket

api = APIBlueprint(
    "api_rosbridge",
    __name__,
    url_prefix="/api/v1",
    operation_id_callback=operation_id,
    abp_tags=[Tag(name="Runs", description="Submit runs and follow them.")],
)
_log = structlog.get_logger()
_UPGRADED: Any = {
    101: {
        "description": "The WebSocket is open, and the run has started: Location is its address",
        "headers": {"Location": {"schema": {"type": "string"}}},
    }
}


class BridgeQuery(BaseModel):
    """The run of a connected program."""

    model_config = ConfigDict(extra="forbid")

    benchmark: Annotated[str, Field(max_length=100, description="Benchmark of controllers")]
    config: Json[dict[str, Any]] = Field(
        default="{}",
        validate_default=True,
        description="Settings that differ from their defaults, as a JSON object",
    )
    seed: int | None = Field(None, description="Random if omitted")
    trials: int | None = Field(None, description="One if omitted")
    title: str = Field("", max_length=200, description="Title of the run")
    axes: Axes = Field(
        Axes.NED,
        description="Axes of topics and references: ned, as in Seamark, or enu, as in ROS REP 103",
    )


@api.get("/rosbridge", responses=_UPGRADED)
@rate_limits.limiter.limit(rate_limits.SUBMISSIONS, key_func=rate_limits.client)
def connect(query: BridgeQuery) -> Response:
    """Connect a program to a practice run by a WebSocket that speaks rosbridge v2.

    Needs a token, in the header Authorization. One session per account; it ends after 15 minutes,
    60 s without a first answer or 10 s without a later one. `seamark bridge rosbridge --server`
    does this for programs that know no tokens. If the token is revoked or expires, or the account
    is disabled, the connection is closed with 1008 within seconds and the run is cancelled.
    """
    if not authentication.by_token():  # no page of another site may use somebody's cookie
        raise Problem("unauthenticated", "Send a token: cookies are not accepted here.")
    access.require(Action.UPLOAD)
    viewer, settings = access.viewer(), services().settings
    wanted = query.model_dump(include={"benchmark", "config", "seed", "trials", "title"})
    sent = Submission(viewer=viewer, controller=ROSBRIDGE, connected=True, **wanted)
    with refusals.as_problems():
        valid = validation.validate(sent, settings)
    if not request.environ.get(UPGRADE):
        upgrade = {"Upgrade": "websocket", "Connection": "Upgrade"}
        raise Problem("upgrade-required", headers=upgrade)
    request.environ[CONVERSATION] = _Conversation(services(), valid, query.axes)
    return Response(status=101)


class _Conversation:
    """A session as the web server carries it out."""

    def __init__(self, current: Services, valid: ValidSubmission, axes: Axes) -> None:
        self._services, self._valid, self._axes = current, valid, axes
        self._credential, self._run_id = authentication.credential(), 0
        self._session = BridgeSession(current.settings, valid.submission.viewer.user_id or 0)

    async def begin(self) -> Mapping[str, str]:
        """Have a slot for the program, then insert its run there; raises Problem."""
        try:
            slot = await self._session.offer()
            self._run_id = await asyncio.to_thread(self._started, slot)
            await self._session.start(self._run_id, SetAxes(axes=self._axes).model_dump_json())
        except SessionRefused as refused:
            raise _later(refused.slug, str(refused)) from None
        return {"Location": f"/api/v1/runs/{self._run_id}"}

    def _started(self, slot: str) -> int:
        """Return the run, which nobody has seen in the queue."""
        settings = self._services.settings
        try:
            with refusals.as_problems(), self._services.database.writing() as database:
                run_id = submission.submit(database, self._valid, settings)
                queue.start(database, run_id, slot, settings)
        except StorageUnavailable as error:
            raise _later("storage-unavailable", str(error)) from None
        except DATABASE_AWAY:
            raise _later("unavailable", "") from None
        return run_id

    async def run(self, socket: WebSocket) -> str:
        with self._services.streams.access.watching(self._credential, self._session.refuse):
            wrong = await self._session.run(socket)
        if self._session.refused:
            await asyncio.to_thread(self._cancel)
            raise NotAllowed(wrong)
        return wrong

    def _cancel(self) -> None:
        """Cancel the run: its program has not failed, and has not disconnected either."""
        try:
            cancellation.cancel(self._services.database, self._services.redis, self._run_id)
        except DATABASE_AWAY as error:  # it fails as that of a lost program
            _log.warning("run_not_cancelled", run=self._run_id, error=str(error))

    async def end(self) -> None:
        await self._session.end()


def _later(slug: str, sentence: str) -> Problem:
    return Problem(slug, sentence, headers={"Retry-After": str(BUSY_RETRY_S)})
