"""Who may call what: every route, for every role with every set of scopes.

A route without an entry in `ROUTES` fails. What an entry allows is written here independently of
`seamark.server.accounts.permissions`.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import chain, combinations
from typing import Any

import pytest
from flask.testing import FlaskClient

from seamark.server.accounts import accounts
from seamark.server.accounts.permissions import ACCOUNT_ROLES
from seamark.server.app import create_app
from seamark.server.classes import assignments, classrooms
from seamark.server.classes.assignments import Draft
from seamark.server.database.sweep_tables import Sweep
from seamark.server.web import authentication
from tests.cast import Backend
from tests.server.api.conftest import Site

READ, SUBMIT, ADMIN = "read", "submit", "admin"
SETS = [
    frozenset(scopes)
    for scopes in chain(*(combinations((READ, SUBMIT, ADMIN), count) for count in (1, 2, 3)))
]
ALL = frozenset({READ, SUBMIT, ADMIN})
REFUSED = {401, 403, 404}
TO_SIGN_IN = "/sign-in?next="


@dataclass(frozen=True)
class Caller:
    """A role, and the scopes of its token; a browser has a cookie and no token."""

    role: str  # "anonymous", "guest", or a name of the cast: ann owns, ben does not, see ROLES
    scopes: frozenset[str] | None = None

    def __str__(self) -> str:
        return self.role if self.scopes is None else f"{self.role}-{'+'.join(sorted(self.scopes))}"

    def has(self, scope: str) -> bool:
        return self.scopes is None or scope in self.scopes

    @property
    def signed_in(self) -> bool:
        return self.role in ROLES

    def is_at_least(self, role: str) -> bool:
        """Return whether the rights of a role apply, which need the scope "admin"."""
        return self.signed_in and RANK[ROLES[self.role]] >= RANK[role] and self.has(ADMIN)

    @property
    def administers(self) -> bool:
        return self.is_at_least("admin")


RANK = {"user": 0, "teacher": 1, "organiser": 2, "admin": 3}
ROLES = {"ann": "user", "ben": "user", "tim": "teacher", "olga": "organiser", "root": "admin"}
# The scope "admin" of a user has no effect: one such token for each.
OF_USER = [scopes for scopes in SETS if scopes == ALL or ADMIN not in scopes]
CALLERS = [
    Caller("anonymous"),
    Caller("guest"),
    *(Caller(name, scopes) for name in ("tim", "olga", "root") for scopes in (None, *SETS)),
    *(Caller("ann", scopes) for scopes in (None, *OF_USER)),
    *(Caller("ben", scopes) for scopes in (None, ALL)),
]
Allows = Callable[[Caller], bool]


def everybody(caller: Caller) -> bool:
    return True


def lists(caller: Caller) -> bool:
    return caller.has(READ)


def submits(caller: Caller) -> bool:
    return caller.has(SUBMIT)


def submits_as_somebody(caller: Caller) -> bool:
    return caller.has(SUBMIT) and caller.role != "anonymous"


def uploads(caller: Caller) -> bool:
    return caller.signed_in and caller.has(SUBMIT)


def reads_account(caller: Caller) -> bool:
    return caller.signed_in and caller.has(READ)


def changes_tokens(caller: Caller) -> bool:
    return caller.signed_in and caller.has(SUBMIT)


def reads_its_own(caller: Caller) -> bool:
    return caller.role == "ann" and caller.has(READ)


def changes_its_own(caller: Caller) -> bool:
    return caller.role == "ann" and caller.has(SUBMIT)


def changes_password(caller: Caller) -> bool:
    return caller.signed_in and caller.scopes is None


def reads_run(caller: Caller) -> bool:
    return caller.has(READ) and (caller.role == "ann" or caller.administers)


def changes_run(caller: Caller) -> bool:
    return caller.has(SUBMIT) and (caller.role == "ann" or caller.administers)


def withdraws(caller: Caller) -> bool:
    return caller.has(SUBMIT) and (caller.role == "ann" or caller.is_at_least("organiser"))


def invites(caller: Caller) -> bool:
    return caller.is_at_least("teacher")


def teaches(caller: Caller) -> bool:
    return caller.has(READ) and (caller.role == "tim" or caller.administers) and caller.has(ADMIN)


def has_classes(caller: Caller) -> bool:
    return caller.is_at_least("teacher")


def sees_class(caller: Caller) -> bool:
    return reads_its_own(caller) or teaches(caller)


ORDER: dict[str, Any] = {"json": {"benchmark": "currents-v1", "controller": "pi"}}
TOKEN: dict[str, Any] = {"json": {"name": "t", "scopes": ["submit"]}}
FORM = {"controller": "pi", "kind": "practice"}
SWEEP: dict[str, Any] = {
    "benchmark": "currents-v1",
    "controller": "pi",
    "sweep": [{"name": "kp", "values": [0.2, 0.4]}],
}
UPLOAD: dict[str, Any] = {"json": {"benchmark": "currents-v1"}}
NEW_NAME = {"name": "someone", "password": "a long pass phrase"}
WRONG = {"old": "not the password", "new": "a long pass phrase"}


@dataclass(frozen=True)
class Entry:
    """Who may call a route, how it is called, and the status for who may."""

    allows: Allows
    status: int = 200
    path: str = ""  # the route itself if it has no variable part
    options: Any = None
    run: str = ""  # the state of ann's new run whose number replaces {run}; empty: an old one


def _reading(*names: str) -> dict[tuple[str, str], Entry]:
    root = "/api/v1/runs/"
    return {
        ("GET", f"{root}<int:run_id>{name}"): Entry(reads_run, path=f"{root}{{run}}{name}")
        for name in names
    }


def _changing(
    root: str, variable: str, status: int, **entries: tuple[Allows, str]
) -> dict[tuple[str, str], Entry]:
    return {
        ("POST", f"{root}{variable}/{name}"): Entry(
            allows, status, f"{root}{{run}}/{name}", run=run
        )
        for name, (allows, run) in entries.items()
    }


ACTIONS = {
    "cancel": (changes_run, "queued"),
    "publish": (changes_run, "recorded"),
    "withdraw": (withdraws, "public"),
}
DELETE_DATA = {"delete-data": (changes_run, "recorded")}
EDIT = {"edit": (changes_run, "recorded"), "delete": (changes_run, "recorded")}
RERUN = {"rerun": (changes_its_own, "recorded")}
CODE: dict[str, Any] = {"code": "0000000000"}
TASK = {"title": "Hold", "benchmark": "currents-v1"}
A, AS = "/assignments/{assignment}", "/assignments/<row:assignment_id>"
C, CS = "/classes/{class}", "/classes/<row:class_id>"
API_A, API_AS = "/api/v1/assignments/{assignment}", "/api/v1/assignments/<int:assignment_id>"
API_C, API_CS = "/api/v1/classes/{class}", "/api/v1/classes/<int:class_id>"
CLASSES: dict[tuple[str, str], Entry] = {  # ann is in a class of tim
    ("GET", "/classes/"): Entry(reads_account),
    ("POST", "/classes/"): Entry(has_classes, 303, options={"data": {"name": "5b"}}),
    ("POST", "/classes/join"): Entry(changes_tokens, 422, options={"data": CODE}),
    ("GET", CS): Entry(sees_class, path=C),
    ("POST", CS): Entry(teaches, 303, C, {"data": {"name": "5c"}}),
    ("POST", f"{CS}/code"): Entry(teaches, 303, f"{C}/code"),
    ("POST", f"{CS}/archive"): Entry(teaches, 303, f"{C}/archive"),
    ("POST", f"{CS}/delete"): Entry(teaches, 303, f"{C}/delete"),
    ("POST", f"{CS}/leave"): Entry(changes_its_own, 303, f"{C}/leave"),
    ("GET", f"{CS}/pupils"): Entry(teaches, path=f"{C}/pupils"),
    ("POST", f"{CS}/pupils/<row:user_id>/remove"): Entry(
        teaches, 303, f"{C}/pupils/{{pupil}}/remove"
    ),
    ("GET", f"{CS}/assignments/new"): Entry(teaches, path=f"{C}/assignments/new"),
    ("POST", f"{CS}/assignments"): Entry(teaches, 303, f"{C}/assignments", {"data": TASK}),
    ("GET", AS): Entry(sees_class, path=A),
    ("POST", AS): Entry(teaches, 303, A, {"data": TASK}),
    ("POST", f"{AS}/delete"): Entry(teaches, 303, f"{A}/delete"),
    ("GET", f"{AS}/pupils.csv"): Entry(teaches, path=f"{A}/pupils.csv"),
    ("GET", "/api/v1/classes"): Entry(reads_account),
    ("POST", "/api/v1/classes"): Entry(has_classes, 201, options={"json": {"name": "5b"}}),
    ("POST", "/api/v1/classes/join"): Entry(changes_tokens, 422, options={"json": CODE}),
    ("GET", API_CS): Entry(sees_class, path=API_C),
    ("PATCH", API_CS): Entry(teaches, path=API_C, options={"json": {"name": "5c"}}),
    ("DELETE", API_CS): Entry(teaches, 204, API_C),
    ("POST", f"{API_CS}/leave"): Entry(changes_its_own, 204, f"{API_C}/leave"),
    ("GET", f"{API_CS}/pupils"): Entry(teaches, path=f"{API_C}/pupils"),
    ("DELETE", f"{API_CS}/pupils/<int:user_id>"): Entry(teaches, 204, f"{API_C}/pupils/{{pupil}}"),
    ("GET", f"{API_CS}/assignments"): Entry(sees_class, path=f"{API_C}/assignments"),
    ("POST", f"{API_CS}/assignments"): Entry(teaches, 201, f"{API_C}/assignments", {"json": TASK}),
    ("GET", API_AS): Entry(sees_class, path=API_A),
    ("PATCH", API_AS): Entry(teaches, path=API_A, options={"json": {"title": "Hold on"}}),
    ("DELETE", API_AS): Entry(teaches, 204, API_A),
    ("GET", f"{API_AS}/pupils"): Entry(teaches, path=f"{API_A}/pupils"),
    ("GET", f"{API_AS}/runs"): Entry(sees_class, path=f"{API_A}/runs"),
    ("GET", f"{API_AS}/ranking"): Entry(teaches, path=f"{API_A}/ranking"),
}
OPEN = Entry(everybody)
ROUTES: dict[tuple[str, str], Entry] = {
    ("GET", "/static/<path:filename>"): Entry(everybody, path="/static/logo.svg"),
    ("GET", "/"): OPEN,
    ("GET", "/submit/"): Entry(everybody, 302),
    ("GET", "/submit/<name>"): Entry(everybody, path="/submit/currents-v1"),
    ("POST", "/submit/<name>"): Entry(submits, 303, "/submit/currents-v1", {"data": FORM}),
    ("POST", "/demo"): Entry(submits, 303),
    ("GET", "/benchmarks/"): OPEN,
    ("GET", "/benchmarks/<name>"): Entry(everybody, path="/benchmarks/currents-v1"),
    ("GET", "/runs/<row:run_id>"): Entry(reads_run, path="/runs/{run}"),
    ("GET", "/runs/<row:run_id>/embed"): Entry(reads_run, path="/runs/{run}/embed"),
    **_changing("/runs/", "<row:run_id>", 303, **ACTIONS, **DELETE_DATA, **EDIT),
    ("GET", "/runs/"): Entry(lists),
    ("GET", "/sweeps/<row:sweep_id>"): Entry(reads_run, path="/sweeps/{sweep}"),
    ("POST", "/sweeps/<row:sweep_id>/cancel"): Entry(changes_run, 303, "/sweeps/{sweep}/cancel"),
    ("POST", "/api/v1/sweeps"): Entry(submits, 202, options={"json": SWEEP}),
    ("GET", "/api/v1/sweeps/<int:sweep_id>"): Entry(reads_run, path="/api/v1/sweeps/{sweep}"),
    ("POST", "/api/v1/sweeps/<int:sweep_id>/cancel"): Entry(
        changes_run, 200, "/api/v1/sweeps/{sweep}/cancel"
    ),
    ("GET", "/runs/runs.csv"): Entry(lists),
    ("POST", "/runs/selected"): Entry(submits_as_somebody, 303),
    ("GET", "/leaderboards/"): Entry(everybody, 302),
    ("GET", "/leaderboards/<name>"): Entry(everybody, path="/leaderboards/currents-v1"),
    ("GET", "/users/<name>"): Entry(everybody, 404, "/users/nobody-there"),
    ("GET", "/api/v1/users/<string:name>"): Entry(everybody, 404, "/api/v1/users/nobody-there"),
    ("GET", "/profile"): Entry(reads_account),
    ("POST", "/profile"): Entry(changes_tokens, 303, options={"data": {"affiliation": "A"}}),
    ("PUT", "/api/v1/me/profile"): Entry(changes_tokens, options={"json": {"affiliation": "A"}}),
    ("GET", "/sign-up"): OPEN,
    ("POST", "/sign-up"): Entry(everybody, 302, options={"data": NEW_NAME}),
    ("GET", "/sign-in"): OPEN,
    ("POST", "/sign-in"): Entry(everybody, 422, options={"data": WRONG}),
    ("POST", "/sign-out"): Entry(everybody, 302),
    ("GET", "/tokens"): Entry(reads_account),
    ("POST", "/tokens"): Entry(changes_tokens, options={"data": {"scopes": "submit"}}),
    ("POST", "/tokens/<row:token_id>/revoke"): Entry(
        changes_its_own, 302, "/tokens/{token}/revoke"
    ),
    ("GET", "/account"): Entry(reads_account),
    ("GET", "/account/data.zip"): Entry(reads_account),
    ("POST", "/account/browsers/sign-out"): Entry(changes_password, 404),
    ("POST", "/account/delete"): Entry(changes_password, 422, options={"data": WRONG}),
    ("GET", "/reset"): OPEN,
    ("POST", "/reset"): Entry(everybody, 422, options={"data": WRONG}),
    ("POST", "/password"): Entry(changes_password, 422, options={"data": WRONG}),
    ("GET", "/invitations"): Entry(invites),
    ("POST", "/invitations"): Entry(invites, options={"data": {"count": "2"}}),
    **CLASSES,
    ("GET", "/docs/"): Entry(everybody, 302),
    ("GET", "/docs/search"): Entry(everybody),
    ("GET", "/docs/<name>"): Entry(everybody, path="/docs/start"),
    ("GET", "/docs/guides/<path:name>"): Entry(everybody, path="/docs/guides/benchmarks.md"),
    ("GET", "/docs/physics/<name>.urdf"): Entry(everybody, path="/docs/physics/girona500.urdf"),
    ("GET", "/status"): OPEN,
    ("GET", "/problems"): OPEN,
    ("GET", "/problems/<slug>"): Entry(everybody, path="/problems/not-found"),
    ("GET", "/healthz"): OPEN,
    ("GET", "/readyz"): Entry(everybody, 503),  # there is no worker
    ("GET", "/metrics"): OPEN,
    ("GET", "/api/docs"): OPEN,
    ("GET", "/api/v1/openapi.json"): OPEN,
    ("GET", "/api/v1/benchmarks"): OPEN,
    ("GET", "/api/v1/benchmarks/<string:benchmark>"): Entry(
        everybody, path="/api/v1/benchmarks/currents-v1"
    ),
    ("GET", "/api/v1/leaderboards/<string:benchmark>"): Entry(
        everybody, path="/api/v1/leaderboards/currents-v1"
    ),
    ("GET", "/api/v1/environment"): OPEN,
    ("GET", "/api/v1/me"): OPEN,
    ("GET", "/api/v1/me/data.zip"): Entry(reads_account),
    ("GET", "/api/v1/runs"): Entry(lists),
    ("POST", "/api/v1/runs"): Entry(submits, 202, options=ORDER),
    ("POST", "/api/v1/checks"): Entry(uploads, 422, options=UPLOAD),  # there is no worker
    ("GET", "/api/v1/checks/<int:check_id>"): Entry(reads_its_own, path="/api/v1/checks/{check}"),
    **_reading("", "/events", "/telemetry.csv", "/telemetry.f64", "/series.json", "/metrics.json"),
    **_reading("/manifest.json", "/config.json", "/log", "/program", "/camera.jpg", "/dataset.zip"),
    **_reading("/scene.json", "/texture.jpg", "/moments.json"),
    ("GET", "/compare"): Entry(reads_run, path="/compare?runs={run},{other}"),
    ("GET", "/compare/preview.jpg"): Entry(
        reads_run, path="/compare/preview.jpg?runs={run},{other}"
    ),
    ("GET", "/runs/<row:run_id>/preview.jpg"): Entry(reads_run, path="/runs/{run}/preview.jpg"),
    ("GET", "/leaderboards/<name>/preview.jpg"): Entry(
        everybody, path="/leaderboards/currents-v1/preview.jpg"
    ),
    ("GET", "/api/v1/compare"): Entry(reads_run, path="/api/v1/compare?runs={run},{other}"),
    **_changing("/api/v1/runs/", "<int:run_id>", 200, **ACTIONS),
    **_changing("/api/v1/runs/", "<int:run_id>", 202, **RERUN),
    ("PATCH", "/api/v1/runs/<int:run_id>"): Entry(
        changes_run, path="/api/v1/runs/{run}", options={"json": {"title": "t"}}, run="recorded"
    ),
    ("DELETE", "/api/v1/runs/<int:run_id>"): Entry(
        changes_run, 204, "/api/v1/runs/{run}", run="recorded"
    ),
    ("DELETE", "/api/v1/runs/<int:run_id>/data"): Entry(
        changes_run, path="/api/v1/runs/{run}/data", run="recorded"
    ),
    ("GET", "/api/v1/tokens"): Entry(reads_account),
    ("POST", "/api/v1/tokens"): Entry(changes_tokens, 201, options=TOKEN),
    ("POST", "/api/v1/invitations"): Entry(invites, 201, options={"json": {"count": 2}}),
    ("DELETE", "/api/v1/tokens/<int:token_id>"): Entry(
        changes_its_own, 204, "/api/v1/tokens/{token}"
    ),
}


@pytest.fixture
def site(backend: Backend) -> Iterator[Site]:
    settings = backend.settings.model_copy(update={"quota_live": 1000, "quota_day": 1000})
    app = create_app(settings)
    app.config.update(WTF_CSRF_METHODS=[])
    site = Site(backend.database, settings, backend.viewers, app, headers={})
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
    return site.publish(run_id) if state == "public" else run_id


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


def test_an_expired_token_is_refused_everywhere(site: Site) -> None:
    with site.database.writing() as session:
        text = accounts.new_token(session, site.user_id("ann"), "old", [READ, SUBMIT], days=-1.0)
    headers, recorded = {"Authorization": f"Bearer {text}"}, site.recorded()

    statuses = {
        site.client()
        .open(path_of(site, route, entry, recorded), method=method, headers=headers)
        .status_code
        for (method, route), entry in ROUTES.items()
        if not route.startswith("/static/")
    }

    assert statuses == {401}
