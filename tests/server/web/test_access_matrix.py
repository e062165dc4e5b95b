"""Who may call what: every route, for every role with every set of scopes.

What a caller may do is written in `callers`, and for which routes it counts in `routes`.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from string import Formatter
from typing import Any

import pytest
from flask.testing import FlaskClient

from seamark.server.accounts import accounts
from seamark.server.accounts.permissions import ACCOUNT_ROLES, Role
from seamark.server.app import create_app
from seamark.server.classes import assignments, classrooms
from seamark.server.classes.assignments import Draft
from seamark.server.database.rejudgement_tables import Rejudgement
from seamark.server.database.submission_tables import Sweep
from seamark.server.monitoring import meters
from seamark.server.runs.downloads.conversions import Conversions
from seamark.server.web import authentication
from seamark.server.web.asgi import APART
from tests.cast import Backend
from tests.part_programs import BENCHMARK, TRACKER
from tests.server.api.conftest import Site
from tests.server.judging.cup import Cup
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

MADE_TOGETHER = {
    "class": {"assignment", "pupil"},
    "cup": {"member", "entry"},
    "decided": {"placed"},
}


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
    site.sign_up("otto", role=Role.ORGANISER)
    # Who may have a file is decided before it is written; writing them all takes minutes.
    written = Conversions(command=("true",))
    app.extensions["seamark"] = replace(site.services, conversions=written)
    yield site
    # Or the service would add thousands of series to those of all processes as it ends.
    meters.HTTP_REQUESTS.clear()
    meters.HTTP_SECONDS.clear()
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


class Objects:
    """What requests act on; each is made anew once a caller who may has acted on it."""

    def __init__(self, site: Site) -> None:
        self._site = site
        self._made: dict[str, dict[str, object]] = {}
        self._competitions = 0
        self._makers: dict[str, Callable[[], dict[str, object]]] = {
            "run": lambda: {"run": self._run("recorded")},
            "other": lambda: {"other": self._run("recorded")},
            "user": lambda: {"user": site.user_id("eva")},
            "check": lambda: {"check": site.queue_check("ann")},
            "class": self._class,
            "cup": self._cup,
            "draft": lambda: {"draft": Cup.draft(site, name=self._new_name()).view.name},
            "closed": self._closed,
            "decided": self._decided,
            "sweep": self._sweep,
            "rejudgement": self._rejudgement,
            "token": self._token,
        }

    def path_of(self, route: str, entry: Entry) -> str:
        """Return the address to call."""
        values: dict[str, object] = {}
        for kind in _kinds(route, entry):
            if kind not in self._made:
                make = self._makers.get(kind, lambda: {"run": self._run(entry.run)})
                self._made[kind] = make()
            values |= self._made[kind]
        return (entry.path or route).format(**values)

    def acted_on(self, route: str, entry: Entry) -> None:
        """Forget what the address of a request names."""
        for kind in _kinds(route, entry):
            self._made.pop(kind, None)

    def _run(self, state: str) -> int:
        self._site.clear_queue()  # the next run that is claimed is the one that is queued here
        self._made.pop("queued run", None)
        if state == "queued":
            return self._site.queue("ann")
        if state == "own vehicle":
            vehicle = self._site.store_vehicle()
            return self._site.recorded(vehicle=vehicle, config={"vehicle": vehicle.name})
        if state == "own tracker":
            tracker = self._site.store_program(TRACKER, role="tracker")
            return self._site.recorded(benchmark=BENCHMARK, parts={"tracker": tracker})
        run_id = self._site.recorded()
        if state == "recorded":
            return run_id
        return self._site.publish(run_id, anonymous=state == "anonymous")

    def _class(self) -> dict[str, object]:
        """Make a class of tim, in which ann is, with an assignment."""
        site = self._site
        with site.database.writing() as session:
            class_id = classrooms.create(session, site.user_id("tim"), "5a")
            room = classrooms.find(session, class_id)
            assert room is not None
            classrooms.join(session, site.user_id("ann"), room.code)
            draft = Draft(title="Hold", benchmark="currents-v1", config={})
            assignment = assignments.create(session, class_id, draft, trials_max=1)
        return {"class": class_id, "assignment": assignment, "pupil": site.user_id("ann")}

    def _cup(self) -> dict[str, object]:
        """Open a competition of olga's, in which ann's team has an entry and eva as a member."""
        cup = Cup.opened(self._site, name=self._new_name())
        cup.team("ann", "eva")
        entry = cup.entered("eva", [40.0, 41.0, 42.0])
        return {"cup": cup.view.name, "member": self._site.user_id("eva"), "entry": entry}

    def _closed(self) -> dict[str, object]:
        cup = Cup.opened(self._site, name=self._new_name())
        cup.close_qualification()
        return {"closed": cup.view.name}

    def _decided(self) -> dict[str, object]:
        cup = Cup.opened(self._site, name=self._new_name())
        team = cup.team("ann")
        cup.entered("ann", [40.0, 41.0, 42.0])
        cup.begin_final()
        cup.play_batch({})
        cup.advance()
        return {"decided": cup.view.name, "placed": team}

    def _new_name(self) -> str:
        self._competitions += 1
        return f"cup-{self._competitions}-v1"

    def _sweep(self) -> dict[str, object]:
        with self._site.database.writing() as session:
            user_id = self._site.user_id("ann")
            sweep = Sweep(user_id=user_id, benchmark="currents-v1", created_at=0.0)
            sweep.axes = [{"name": "kp", "values": [0.2, 0.4]}]
            session.add(sweep)
            session.flush()
            return {"sweep": sweep.id}

    def _rejudgement(self) -> dict[str, object]:
        with self._site.database.writing() as session:
            row = Rejudgement(benchmark="currents-v1", reason="Why", chosen={}, created_by="root")
            row.created_at = 0.0
            session.add(row)
            session.flush()
            return {"rejudgement": row.id}

    def _token(self) -> dict[str, object]:
        with self._site.database.writing() as session:
            accounts.new_token(session, self._site.user_id("ann"), "spare", [READ])
            return {"token": accounts.tokens(session, self._site.user_id("ann"))[0].id}


def _kinds(route: str, entry: Entry) -> set[str]:
    """Return what the address of a route names."""
    names = {name for _, name, _, _ in Formatter().parse(entry.path or route) if name}
    if entry.run:
        names = names - {"run"} | {f"{entry.run} run"}
    for kind, others in MADE_TOGETHER.items():
        if names & others:
            names = names - others | {kind}
    return names


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


def _parameter(caller: Caller) -> Any:
    """Keep two of the three scopes for the long tests, except of an admin, who can do the most."""
    two_scopes = caller.role in ("tim", "olga") and len(caller.scopes or ()) == 2
    return pytest.param(caller, id=str(caller), marks=[pytest.mark.long] if two_scopes else [])


@pytest.mark.slow
@pytest.mark.parametrize("caller", [_parameter(caller) for caller in CALLERS])
def test_a_caller_gets_through_exactly_where_the_entries_allow_it(
    site: Site, caller: Caller
) -> None:
    wrong, objects, headers = [], Objects(site), headers_of(site, caller)
    client = browser_of(site, caller)
    for (method, route), entry in ROUTES.items():
        path = objects.path_of(route, entry)
        options = entry.options or {}
        with client.open(path, method=method, headers=headers, **options) as answer:
            status, location = answer.status_code, answer.headers.get("Location", "")
        if not _as_expected(entry, caller, status, location):
            wrong.append((method, path, status))
        if method != "GET" and entry.allows(caller):
            objects.acted_on(route, entry)
            client = browser_of(site, caller)  # some routes sign in or out

    assert wrong == []


def _as_expected(entry: Entry, caller: Caller, status: int, location: str) -> bool:
    if entry.allows(caller):
        return status == entry.status and not location.startswith(TO_SIGN_IN)
    return status in REFUSED or location.startswith(TO_SIGN_IN)


@pytest.mark.slow
@pytest.mark.parametrize("caller", CALLERS, ids=str)
def test_only_who_administers_sees_the_private_runs_of_others(site: Site, caller: Caller) -> None:
    site.sign_up("zoe")
    site.succeeded("zoe", title="secret plan")
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
    headers, objects = {"Authorization": f"Bearer {text}"}, Objects(site)

    # Health is the same for all, and asked without a look at who asks: the database may hang.
    statuses = {
        site.client()
        .open(objects.path_of(route, entry), method=method, headers=headers)
        .status_code
        for (method, route), entry in ROUTES.items()
        if not route.startswith("/static/") and route not in APART
    }

    assert statuses == {401}
