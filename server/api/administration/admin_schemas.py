"""Request and response models of the administration."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from seamark.server.accounts import audit
from seamark.server.administration.live_runs import WAITING_MAX
from seamark.server.administration.people import PAGE_MAX, QUOTA_DAY_MAX, SEARCH_MAX
from seamark.server.api.requests.query import Query
from seamark.server.api.requests.schemas import ResponseModel, Text
from seamark.server.web.url_converters import ROW_ID_MAX

RoleName = Literal["user", "teacher", "organiser", "admin"]


class AccountPath(BaseModel):
    """Path parameter of an account."""

    user_id: int = Field(ge=1, le=ROW_ID_MAX, description="Id of the account")


class WorkerPath(BaseModel):
    """Path parameter of a worker."""

    worker: str = Field(min_length=1, max_length=255, description="For example worker1@host")


class WorkerChange(BaseModel):
    """What changes of a worker."""

    model_config = ConfigDict(extra="forbid")

    drained: bool = Field(description="true: it ends the runs that it has and claims no more")


class AccountsQuery(Query):
    """Filters and pagination of accounts, newest first."""

    q: Text = Field("", max_length=SEARCH_MAX, description="Part of the name")
    role: RoleName | None = None
    disabled: bool = Field(False, description="Only disabled accounts")
    after: int | None = Field(None, ge=1, le=ROW_ID_MAX, description="`next` of the previous page")
    limit: int = Field(50, ge=1, le=PAGE_MAX)


class AccountChange(BaseModel):
    """What changes of an account; what is left out stays."""

    model_config = ConfigDict(extra="forbid")

    role: RoleName | None = None
    quota_day: int | None = Field(
        None,
        ge=0,
        le=QUOTA_DAY_MAX,
        description="Runs in 24 hours; null: as many as the service's setting says",
    )
    disabled: bool | None = Field(
        None, description="true: refused everywhere at once, its active runs are cancelled"
    )


class AccountDeletionQuery(Query):
    """What happens to the published runs of an account that is deleted."""

    keep_published: bool = Field(False, description="Leave them under the name Deleted user")


class AuditQuery(Query):
    """Filters and pagination of the audit log, newest first."""

    action: Text = Field("", max_length=40, description="For example role_changed")
    actor: Text = Field("", max_length=80, description="Name of the account that did it")
    target: Text = Field("", max_length=audit.TARGET_MAX, description="To whom or to what")
    after: int | None = Field(None, ge=1, le=ROW_ID_MAX, description="`next` of the previous page")
    limit: int = Field(audit.PAGE, ge=1, le=audit.PAGE_MAX)


class OverviewResponse(ResponseModel):
    """The state of the service, and what needs attention."""

    queued: int
    running: int
    oldest_queued_at: float | None
    slots: int
    free_bytes: int
    ended: dict[str, int] = Field(description="In the last 24 hours, by state")
    causes: dict[str, int] = Field(description="Of failures in the last 24 hours")
    alerts: list[str]


class WorkerResponse(ResponseModel):
    """A worker with the runs that it evaluates."""

    name: str
    alive: bool
    drained_at: float | None
    outdated: bool = Field(description="It would compute other results, and starts no runs")
    version: str
    level: str
    languages: list[str]
    slots: int
    seen_at: float
    started_at: float
    findings: list[dict[str, Any]]
    processes: dict[str, str]
    runs: list[int]


class WorkersResponse(ResponseModel):
    """The workers that were seen in the last 24 hours."""

    workers: list[WorkerResponse]


class LiveRunResponse(ResponseModel):
    """A run that waits or is evaluated."""

    id: int
    user: str | None = Field(description="null: a guest")
    benchmark: str
    kind: str
    controller: str
    program_name: str | None
    language: str | None = Field(description="Of an uploaded program")
    expected_s: float | None = Field(description="Expected duration of the evaluation [s]")
    queued_at: float
    started_at: float | None
    progress: float
    attempt: int
    rejudges: int | None = Field(description="The run that a rejudgement computes again")
    worker: str | None


class QueueResponse(ResponseModel):
    """The queue."""

    queued: int = Field(description="All runs that wait")
    waiting: list[LiveRunResponse] = Field(
        description=f"The first {WAITING_MAX}, in the order in which they will start"
    )
    running: list[LiveRunResponse]


class UsageResponse(ResponseModel):
    """Room that something takes."""

    name: str
    bytes: int
    count: int = Field(description="Runs or files")


class OwnerResponse(UsageResponse):
    """Room that the runs of an owner take."""

    user_id: int | None = Field(description="null: guests, a deleted account, a baseline")


class StorageResponse(ResponseModel):
    """What takes how much room, and what retention would delete."""

    measured_at: float = Field(description="0: not yet")
    total_bytes: int
    free_bytes: int
    areas: list[UsageResponse]
    owners: list[OwnerResponse] = Field(description="Those who take most")
    due: list[UsageResponse] = Field(description="What retention would delete, by rule")
    requested_at: float = Field(description="A pass that has not begun; 0: none")
    backup_at: float | None = Field(description="When the last backup was made")


class AccountResponse(ResponseModel):
    """An account."""

    id: int
    name: str
    role: str
    created_at: float
    disabled_at: float | None
    quota_day: int | None


class AccountsResponse(ResponseModel):
    """A page of accounts."""

    users: list[AccountResponse]
    next: int | None


class ResetLinkResponse(ResponseModel):
    """The address at which a new password is set, once."""

    link: str
    hours: int


class AuditEntryResponse(ResponseModel):
    """Something that somebody did."""

    id: int
    at: float
    actor: str
    address: str
    action: str
    target: str
    detail: dict[str, Any]


class AuditResponse(ResponseModel):
    """A page of the audit log; with several filters it may be short before the last one."""

    entries: list[AuditEntryResponse]
    next: int | None
