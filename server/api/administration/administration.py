"""The administration: overview, workers, accounts, audit log. All of it requires the role admin."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from typing import Any, TypeVar

from flask import Response, url_for
from flask_openapi3.blueprint import APIBlueprint
from flask_openapi3.models.tag import Tag
from sqlalchemy.orm import Session

from seamark.server.accounts import audit, password_resets
from seamark.server.accounts.accounts import AccountRejected
from seamark.server.accounts.audit import AuditFilter
from seamark.server.accounts.permissions import Action, Role
from seamark.server.administration import disk, live_runs, overview, people, worker_list
from seamark.server.administration.people import PersonFilter
from seamark.server.administration.worker_list import ListedWorker
from seamark.server.api.administration.admin_schemas import (
    AccountChange,
    AccountDeletionQuery,
    AccountPath,
    AccountResponse,
    AccountsQuery,
    AccountsResponse,
    AuditQuery,
    AuditResponse,
    OverviewResponse,
    QueueResponse,
    ResetLinkResponse,
    StorageResponse,
    WorkerChange,
    WorkerPath,
    WorkerResponse,
    WorkersResponse,
)
from seamark.server.api.requests.operation_ids import operation_id
from seamark.server.database.tables import User
from seamark.server.web import access
from seamark.server.web.problems import Problem
from seamark.server.web.services import services
from seamark.server.web.site_address import site_address

Answer = TypeVar("Answer")
api = APIBlueprint(
    "api_administration",
    __name__,
    url_prefix="/api/v1/admin",
    operation_id_callback=operation_id,
    abp_tags=[Tag(name="Administration", description="Workers, accounts and the audit log.")],
)


@api.before_request
def _only_admins() -> None:
    access.require(Action.ADMINISTER)


@api.get("/overview", responses={200: OverviewResponse})
def show_overview() -> dict[str, Any]:
    """Return the state of the service and what needs attention."""
    held = services()
    with held.database.reading() as session:
        overview_now = overview.overview(session, held.settings)
    names = ("queued", "running", "oldest_queued_at", "slots", "free_bytes", "causes")
    return {name: getattr(overview_now, name) for name in names} | {
        "ended": {state.value: count for state, count in overview_now.ended.items()},
        "alerts": [alert.sentence for alert in overview_now.warnings],
    }


@api.get("/workers", responses={200: WorkersResponse})
def list_workers() -> dict[str, Any]:
    """List the workers that were seen in the last 24 hours, with their runs."""
    with services().database.reading() as session:
        return {"workers": [_worker(each) for each in worker_list.listed(session)]}


@api.patch("/workers/<string:worker>", responses={200: WorkerResponse})
def change_worker(path: WorkerPath, body: WorkerChange) -> dict[str, Any]:
    """Drain a worker, which then claims no more runs, or resume it. Again, it changes nothing."""
    with services().database.writing() as session:
        change = worker_list.drain if body.drained else worker_list.resume
        change(session, access.actor(), path.worker)
        workers = [each for each in worker_list.listed(session) if each.status.name == path.worker]
    if not workers:
        raise Problem("not-found", f"There is no worker {path.worker}.")
    if not body.drained:
        services().wake_worker()
    return _worker(workers[0])


@api.get("/queue", responses={200: QueueResponse})
def show_queue() -> dict[str, Any]:
    """Return the runs that start next, in their order, and those that are evaluated."""
    with services().database.reading() as session:
        live = live_runs.listed(session)
    lists = {"waiting": live.waiting, "running": live.running}
    return {"queued": live.length} | {
        name: [asdict(run) for run in runs] for name, runs in lists.items()
    }


@api.get("/storage", responses={200: StorageResponse})
def show_storage() -> dict[str, Any]:
    """Return what takes how much room, and what retention would delete."""
    held = services()
    with held.database.reading() as session:
        state = disk.state(session, held.settings)
    owners = [
        asdict(owner.usage) | {"name": owner.name, "user_id": owner.user_id}
        for owner in state.owners
    ]
    return {
        "measured_at": state.report.measured_at,
        "total_bytes": state.total_bytes,
        "free_bytes": state.free_bytes,
        "areas": [asdict(usage) for usage in state.report.areas],
        "owners": owners,
        "due": [asdict(usage) for usage in state.report.due],
        "requested_at": state.requested_at,
        "backup_at": None if state.backup is None else state.backup.at,
    }


@api.post("/storage/retention", responses={202: None})
def run_retention() -> Response:
    """Have a worker delete at once what retention would delete in time."""
    with services().database.writing() as session:
        disk.request_retention(session, access.actor())
    return Response(status=202)


@api.get("/users", responses={200: AccountsResponse})
def list_users(query: AccountsQuery) -> dict[str, Any]:
    """List accounts, newest first."""
    role = None if query.role is None else Role[query.role.upper()]
    wanted = PersonFilter(text=query.q.strip(), role=role, disabled=query.disabled)
    with services().database.reading() as session:
        page = people.page(session, wanted, after=query.after, limit=query.limit)
        return {"users": [_account(user) for user in page.people], "next": page.next}


@api.get("/users/<int:user_id>", responses={200: AccountResponse})
def show_user(path: AccountPath) -> dict[str, Any]:
    """Return an account."""
    with services().database.reading() as session:
        return _account(_user(session, path.user_id))


@api.patch("/users/<int:user_id>", responses={200: AccountResponse})
def change_user(path: AccountPath, body: AccountChange) -> dict[str, Any]:
    """Change role, quota or state of an account; not role and state of your own."""
    changes = body.model_dump(exclude_unset=True)
    with services().database.writing() as session:
        user = _user(session, path.user_id)
        _or_conflict(lambda: people.apply(session, access.actor(), user, changes))
        return _account(user)


@api.post("/users/<int:user_id>/revoke", responses={204: None})
def revoke_access(path: AccountPath) -> Response:
    """Sign out all browsers of an account and revoke all its tokens."""
    with services().database.writing() as session:
        people.revoke_access(session, access.actor(), _user(session, path.user_id))
    return Response(status=204)


@api.post("/users/<int:user_id>/reset-link", responses={200: ResetLinkResponse})
def make_reset_link(path: AccountPath) -> dict[str, Any]:
    """Make a link by which the account gets a new password, once. It replaces an earlier one."""
    with services().database.writing() as session:
        user = _user(session, path.user_id)
        text = _or_conflict(lambda: people.make_reset_link(session, access.actor(), user))
    link = site_address() + url_for("own_account.reset", link=text)
    return {"link": link, "hours": password_resets.HOURS}


@api.delete("/users/<int:user_id>", responses={204: None})
def delete_user(path: AccountPath, query: AccountDeletionQuery) -> Response:
    """Delete an account, not your own, with its private runs. This cannot be undone."""
    kept = query.keep_published
    with services().database.writing() as session:
        user = _user(session, path.user_id)
        _or_conflict(lambda: people.close(session, access.actor(), user, keep_published=kept))
    return Response(status=204)


@api.get("/audit", responses={200: AuditResponse})
def list_audit_entries(query: AuditQuery) -> dict[str, Any]:
    """List the entries of the audit log, newest first."""
    wanted = AuditFilter(action=query.action, actor=query.actor, target=query.target)
    with services().database.reading() as session:
        page = audit.page(session, wanted, after=query.after, limit=query.limit)
    return {"entries": [audit.as_dict(entry) for entry in page.entries], "next": page.next}


def _or_conflict(change: Callable[[], Answer]) -> Answer:
    try:
        return change()
    except AccountRejected as reason:
        raise Problem("conflict", str(reason)) from None


def _user(session: Session, user_id: int) -> User:
    user = people.find(session, user_id)
    if user is None:
        raise Problem("not-found", f"There is no account {user_id}.")
    return user


def _account(user: User) -> dict[str, Any]:
    return {name: getattr(user, name) for name in AccountResponse.model_fields}


def _worker(worker: ListedWorker) -> dict[str, Any]:
    names = [name for name in WorkerResponse.model_fields if name != "runs"]
    shown = {name: getattr(worker.status, name) for name in names}
    return shown | {"runs": [run.id for run in worker.runs]}
