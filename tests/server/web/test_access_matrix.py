"""Who may call what: every route, for every role with every set of scopes.

What a caller may do is written in `callers`, and for which routes it counts in `routes`.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import pytest
from flask.testing import FlaskClient

from seamark.server.accounts import accounts
from seamark.server.accounts.permissions import ACCOUNT_ROLES
from seamark.server.app import create_app
from seamark.server.classes import assignments, classrooms
from seamark.server.classes.assignments import Draft
from seamark.server.database.rejudgement_tables import Rejudgement
from seamark.server.database.submission_tables import Sweep
from seamark.server.runs.downloads.conversions import Conversions
from seamark.server.web import authentication
from seamark.server.web.asgi import APART
from tests.cast import Backend
from tests.server.api.conftest import Site
from tests.server.web.callers import (
    CALLERS,
    RANK,
    READ,
    REFUSED,
    ROLES,
    SUBMIT,
    TO_SIGN_IN,
    Caller,
)
from tests.server.web.routes import ROUTES, Entry


@pytest.fixture
def site(backend: Backend) -> Iterator[Site]:
    changes: dict[str, Any] = {
        "quota_live": 1000,
        "quota_day": 1000,
        "mail_url": "smtp://127.0.0.1",
    }
    changes |= {"oidc_issuer": "http://127.0.0.1:1", "oidc_client_id": "seamark"}
    settings = backend.settings.model_copy(update=changes)
    app = create_app(settings)
    app.config.update(WTF_CSRF_METHODS=[])
    site = Site(backend.database, settings, backend.viewers, app, headers={})
    # Who may have a file is decided before it is written; writing them all takes minutes.
    written = Conversions(command=("true",))
    app.extensions["seamark"] = replace(site.services, conversions=written)
    yield site
    site.services.close()


def headers_of(site: Site, caller: Caller) -> dict[str, str]:
    """Return the headers of the caller's requests: with a token if it has scopes."""
    if caller.scopes is None:
        return {}
    with site.database.writing() as session:
        user_id = site.user_id(caller.role)
        text = accounts.new_token(session, user_id, str(caller), caller.scopes)
    return {"Authorization": f"Bearer {text}"}


def browser_of(site: Site, caller: Caller) -> FlaskClient:
    """Return a client with the caller's cookie if it has one."""
    client, cookie = site.client(), dict[str, object]()
    if caller.role == "guest":
        cookie = {"guest": "a guest"}
    elif caller.signed_in and caller.scopes is None:
        with site.app.app_context():
            cookie = authentication.cookie_of(site.user_id(caller.role))
    with client.session_transaction() as session:
        session.update(cookie)
    return client


def path_of(site: Site, route: str, entry: Entry, recorded: int) -> str:
    """Return the address to call, with what it acts on made anew; reading uses `recorded`."""
    path = entry.path or route
    if "{run}" in path:
        path = path.replace("{run}", str(run_of(site, entry.run) if entry.run else recorded))
    if "{other}" in path:
        path = path.replace("{other}", str(run_of(site, "recorded")))
    if "{class}" in path or "{assignment}" in path:
        path = in_class(site, path)
    if "{check}" in path:
        path = path.replace("{check}", str(site.queue_check("ann")))
    if "{sweep}" in path:
        with site.database.writing() as session:
            sweep = Sweep(user_id=site.user_id("ann"), benchmark="currents-v1", created_at=0.0)
            sweep.axes = [{"name": "kp", "values": [0.2, 0.4]}]
            session.add(sweep)
            session.flush()
            path = path.replace("{sweep}", str(sweep.id))
    if "{rejudgement}" in path:
        with site.database.writing() as session:
            row = Rejudgement(benchmark="currents-v1", reason="Why", chosen={}, created_by="root")
            row.created_at = 0.0
            session.add(row)
            session.flush()
            path = path.replace("{rejudgement}", str(row.id))
    path = path.replace("{user}", str(site.user_id("eva")))
    if "{token}" in path:
        with site.database.writing() as session:
            accounts.new_token(session, site.user_id("ann"), "spare", [READ])
            spare = accounts.tokens(session, site.user_id("ann"))[0].id
        path = path.replace("{token}", str(spare))
    return path


def in_class(site: Site, path: str) -> str:
    """Return an address of a new class of tim, in which ann is, with an assignment."""
    with site.database.writing() as session:
        class_id = classrooms.create(session, site.user_id("tim"), "5a")
        room = classrooms.find(session, class_id)
        assert room is not None
        classrooms.join(session, site.user_id("ann"), room.code)
        draft = Draft(title="Hold", benchmark="currents-v1", config={})
        assignment = assignments.create(session, class_id, draft, trials_max=1)
    values = {"class": class_id, "assignment": assignment, "pupil": site.user_id("ann")}
    return path.format(**values)


def run_of(site: Site, state: str) -> int:
    site.clear_queue()  # the next run that is claimed is the one that is queued here
    if state == "queued":
        return site.queue("ann")
    run_id = site.recorded()
    return run_id if state == "recorded" else site.publish(run_id, anonymous=state == "anonymous")


def test_every_role_of_an_account_has_callers_in_the_matrix() -> None:
    called = {ROLES[caller.role] for caller in CALLERS if caller.signed_in}

    assert called == {role.label for role in ACCOUNT_ROLES} == set(RANK)


def test_every_route_has_an_entry(site: Site) -> None:
    routes = {
        (method, rule.rule)
        for rule in site.app.url_map.iter_rules()
        for method in (rule.methods or set()) - {"HEAD", "OPTIONS"}
    }

    assert routes == set(ROUTES)


@pytest.mark.slow
@pytest.mark.parametrize("caller", CALLERS, ids=str)
def test_a_caller_gets_through_exactly_where_the_entries_allow_it(
    site: Site, caller: Caller
) -> None:
    wrong, recorded, headers = [], site.recorded(), headers_of(site, caller)
    for (method, route), entry in ROUTES.items():
        client = browser_of(site, caller)  # anew, since some routes sign in or out
        path = path_of(site, route, entry, recorded)
        options = entry.options or {}
        with client.open(path, method=method, headers=headers, **options) as answer:
            status, location = answer.status_code, answer.headers.get("Location", "")
        if not _as_expected(entry, caller, status, location):
            wrong.append((method, path, status))

    assert wrong == []


def _as_expected(entry: Entry, caller: Caller, status: int, location: str) -> bool:
    if entry.allows(caller):
        return status == entry.status and not location.startswith(TO_SIGN_IN)
    return status in REFUSED or location.startswith(TO_SIGN_IN)


@pytest.mark.slow
@pytest.mark.parametrize("caller", CALLERS, ids=str)
def test_only_who_administers_sees_the_private_runs_of_others(site: Site, caller: Caller) -> None:
    site.succeeded("eva", title="secret plan")
    client, headers = browser_of(site, caller), headers_of(site, caller)
    paths = ("/runs/?of=all", "/runs/runs.csv?of=all", "/api/v1/runs?which=all")

    seen = ["secret plan" in client.get(path, headers=headers).text for path in paths]

    assert seen == [caller.administers and caller.has(READ)] * 3


@pytest.mark.parametrize("path", ["/tokens", "/api/v1/tokens"])
def test_a_token_gives_no_scope_and_no_day_that_it_lacks(site: Site, path: str) -> None:
    root = site.user_id("root")
    with site.database.writing() as session:
        text = accounts.new_token(session, root, "one day", [SUBMIT], days=1.0)
    client, headers = site.client(), {"Authorization": f"Bearer {text}"}
    kind = "json" if path.startswith("/api/") else "data"

    for scopes in (["admin"], ["submit"]):
        body: dict[str, Any] = {kind: {"name": "longer", "scopes": scopes, "days": 365}}
        client.post(path, headers=headers, **body)

    with site.database.reading() as session:
        made = [token for token in accounts.tokens(session, root) if token.name == "longer"]
        first = accounts.tokens(session, root)[-1]
    assert [token.scopes for token in made] == [["submit"]]
    assert made[0].expires_at is not None
    assert first.expires_at is not None
    assert made[0].expires_at <= first.expires_at + 1.0


@pytest.mark.slow
def test_an_expired_token_is_refused_everywhere(site: Site) -> None:
    with site.database.writing() as session:
        text = accounts.new_token(session, site.user_id("ann"), "old", [READ, SUBMIT], days=-1.0)
    headers, recorded = {"Authorization": f"Bearer {text}"}, site.recorded()

    # Health is the same for all, and asked without a look at who asks: the database may hang.
    statuses = {
        site.client()
        .open(path_of(site, route, entry, recorded), method=method, headers=headers)
        .status_code
        for (method, route), entry in ROUTES.items()
        if not route.startswith("/static/") and route not in APART
    }

    assert statuses == {401}
