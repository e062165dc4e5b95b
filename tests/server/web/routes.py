"""Every route of the service, with who may call it. A route without an entry fails a test."""

import time
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Any

from seamark.formats.registry import FORMATS
from seamark.server.web import own_wheel
from tests.cast import VEHICLE
from tests.server.judging.cup import DAY_S, values
from tests.server.web.callers import (
    Allows,
    administers,
    changes_its_own,
    changes_password,
    changes_run,
    changes_tokens,
    connects,
    everybody,
    has_classes,
    holds_competitions,
    invites,
    leaves_team,
    lists,
    organises,
    reads_account,
    reads_its_own,
    reads_run,
    reads_team,
    sees_class,
    submits,
    submits_as_somebody,
    teaches,
    uploads,
    withdraws,
)

ORDER: dict[str, Any] = {"json": {"benchmark": "currents-v1", "controller": "pi"}}
TOKEN: dict[str, Any] = {"json": {"name": "t", "scopes": ["submit"]}}
FORM = {"controller": "pi", "kind": "practice"}
SWEEP: dict[str, Any] = {
    "benchmark": "currents-v1",
    "controller": "pi",
    "sweep": [{"name": "kp", "values": [0.2, 0.4]}],
}
UPLOAD: dict[str, Any] = {"json": {"benchmark": "currents-v1"}}
VEHICLE_FILE: dict[str, Any] = {
    "data": b'--x\r\nContent-Disposition: form-data; name="vehicle"; filename="my.toml"\r\n\r\n'
    + VEHICLE.encode()
    + b"\r\n--x--\r\n",
    "content_type": "multipart/form-data; boundary=x",
}
MULTIPART: dict[str, Any] = {"data": {"log": ""}, "content_type": "multipart/form-data"}
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
    "withdraw": (withdraws, "public"),
}
DELETE_DATA = {"delete-data": (changes_run, "recorded")}
REVEAL = {"reveal": (changes_run, "anonymous")}
VERIFY = {"verify": (changes_run, "public")}
PUBLIC = REVEAL | VERIFY
EDIT = {"edit": (changes_run, "recorded"), "delete": (changes_run, "recorded")}
RERUN = {"rerun": (changes_its_own, "recorded")}
CODE: dict[str, Any] = {"code": "0000000000"}
METHOD = {"method": "Steady hand"}
TASK = {"title": "Hold", "benchmark": "currents-v1"}
A, AS = "/assignments/{assignment}", "/assignments/<row:assignment_id>"
C, CS = "/classes/{class}", "/classes/<row:class_id>"
API_A, API_AS = "/api/v1/assignments/{assignment}", "/api/v1/assignments/<int:assignment_id>"
API_C, API_CS = "/api/v1/classes/{class}", "/api/v1/classes/<int:class_id>"
CLASSES: dict[tuple[str, str], Entry] = {  # ann is in a class of tim
    ("GET", "/classes/"): Entry(reads_account),
    ("POST", "/classes/"): Entry(has_classes, 303, options={"data": {"name": "5b"}}),
    ("POST", "/classes/join"): Entry(changes_tokens, 422, options={"data": CODE}),
    ("GET", "/classes/join/<code>"): Entry(everybody, 404, "/classes/join/0000000000"),
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
API_N, API_NS = "/api/v1/competitions/{cup}", "/api/v1/competitions/<string:name>"
DRAFT = "/api/v1/competitions/{draft}"
CHOICE = "/entries/<int:run_id>/choice"
LATER: dict[str, Any] = {"json": {"until": time.time() + 2 * DAY_S, "reason": "Rain"}}
AGREED: dict[str, Any] = {"json": {"name": "Wreck", "agree": True}}
WRONG_CODE: dict[str, Any] = {"json": {"code": "00000-00000", "agree": True}}
COMPETITIONS: dict[tuple[str, str], Entry] = {  # olga's: ann is captain of a team, with eva
    ("GET", "/api/v1/competitions"): Entry(lists),
    ("POST", "/api/v1/competitions"): Entry(
        holds_competitions, 201, options={"json": values(name="new-cup-v1")}
    ),
    ("GET", API_NS): Entry(lists, path=API_N),
    ("PUT", API_NS): Entry(organises, 200, DRAFT, {"json": values(name="changed-cup-v1")}),
    ("DELETE", API_NS): Entry(organises, 204, DRAFT),
    ("GET", f"{API_NS}/check"): Entry(organises, path=f"{DRAFT}/check"),
    ("POST", f"{API_NS}/open"): Entry(organises, 409, f"{DRAFT}/open"),  # it waits for its check
    ("POST", f"{API_NS}/rounds/<int:number>/move"): Entry(
        organises, 200, f"{API_N}/rounds/2/move", LATER
    ),
    ("POST", f"{API_NS}/hand-over"): Entry(
        organises, 204, f"{API_N}/hand-over", {"json": {"user": "otto"}}
    ),
    ("GET", f"{API_NS}/picture"): Entry(lists, 404, f"{API_N}/picture"),  # it has none
    ("GET", f"{API_NS}/rounds/<int:number>/board"): Entry(lists, path=f"{API_N}/rounds/2/board"),
    ("POST", f"{API_NS}/teams"): Entry(  # its qualification has closed
        changes_tokens, 409, "/api/v1/competitions/{closed}/teams", AGREED
    ),
    ("POST", f"{API_NS}/teams/join"): Entry(changes_tokens, 422, f"{API_N}/teams/join", WRONG_CODE),
    ("GET", f"{API_NS}/team"): Entry(reads_team, path=f"{API_N}/team"),
    ("PATCH", f"{API_NS}/team"): Entry(changes_its_own, 200, f"{API_N}/team", {"json": {}}),
    ("DELETE", f"{API_NS}/team/members/<int:user_id>"): Entry(
        leaves_team, 204, f"{API_N}/team/members/{{member}}"
    ),
    ("GET", f"{API_NS}/entries"): Entry(reads_team, path=f"{API_N}/entries"),
    ("POST", f"{API_NS}/entries/<int:run_id>/withdraw"): Entry(
        changes_its_own, 200, f"{API_N}/entries/{{entry}}/withdraw"
    ),
    ("PUT", f"{API_NS}{CHOICE}"): Entry(
        changes_its_own, 409, f"{API_N}/entries/{{entry}}/choice"
    ),  # the best entries go into the final by themselves
    ("DELETE", f"{API_NS}{CHOICE}"): Entry(
        changes_its_own, 409, f"{API_N}/entries/{{entry}}/choice"
    ),
}
N, NS = "/competitions/{cup}", "/competitions/<name>"
DECIDED = "/competitions/{decided}"
MEMBERS, ENTRIES = "/team/members/<row:user_id>", "/team/entries/<row:run_id>"
UNTIL = datetime.now(UTC) + timedelta(days=2)
MOVED: dict[str, Any] = {
    "data": {"until": UNTIL.strftime("%Y-%m-%dT%H:%M"), "reason": "Rain"},
}
COMPETITION_PAGES: dict[tuple[str, str], Entry] = {
    ("GET", "/competitions/"): Entry(everybody),
    ("GET", "/competitions/new"): Entry(holds_competitions),
    ("POST", "/competitions/new"): Entry(holds_competitions, 422),  # it has no title
    ("GET", NS): Entry(everybody, path=N),
    ("GET", f"{NS}/picture"): Entry(everybody, 404, f"{N}/picture"),  # it has none
    ("GET", f"{NS}/results"): Entry(everybody, path=f"{DECIDED}/results"),
    ("GET", f"{NS}/results/embed"): Entry(everybody, path=f"{DECIDED}/results/embed"),
    ("GET", f"{NS}/audit.json"): Entry(everybody, path=f"{N}/audit.json"),
    ("GET", f"{NS}/archive.zip"): Entry(everybody, path=f"{DECIDED}/archive.zip"),
    ("GET", f"{NS}/certificates/<row:team_id>.svg"): Entry(
        everybody, path=f"{DECIDED}/certificates/{{placed}}.svg"
    ),
    ("POST", f"{NS}/team/methods"): Entry(
        leaves_team, 303, f"{N}/team/methods", {"data": {"method": "PI", "text": "A PI."}}
    ),
    ("GET", f"{NS}/change"): Entry(organises, path="/competitions/{draft}/change"),
    ("POST", f"{NS}/change"): Entry(organises, 422, "/competitions/{draft}/change"),
    ("POST", f"{NS}/delete"): Entry(organises, 303, "/competitions/{draft}/delete"),
    ("POST", f"{NS}/open"): Entry(organises, 303, "/competitions/{draft}/open"),
    ("GET", f"{NS}/organise"): Entry(organises, path=f"{N}/organise"),
    ("POST", f"{NS}/rounds/<int:number>/move"): Entry(organises, 303, f"{N}/rounds/2/move", MOVED),
    ("POST", f"{NS}/hand-over"): Entry(
        organises, 303, f"{N}/hand-over", {"data": {"user": "otto"}}
    ),
    ("GET", f"{NS}/teams.csv"): Entry(organises, path=f"{N}/teams.csv"),
    ("GET", f"{NS}/entries.csv"): Entry(organises, path=f"{N}/entries.csv"),
    ("POST", f"{NS}/teams"): Entry(changes_tokens, 422, f"{N}/teams"),  # it agrees on no rules
    ("GET", f"{NS}/join/<code>"): Entry(everybody, 404, f"{N}/join/0000000000"),
    ("POST", f"{NS}/join"): Entry(changes_tokens, 404, f"{N}/join", {"data": CODE}),
    ("GET", f"{NS}/team"): Entry(reads_team, path=f"{N}/team"),
    ("POST", f"{NS}/team"): Entry(changes_its_own, 303, f"{N}/team", {"data": {"team": "Wreck"}}),
    ("POST", f"{NS}/team/link"): Entry(changes_its_own, 303, f"{N}/team/link"),
    ("POST", f"{NS}/team/leave"): Entry(leaves_team, 303, f"{N}/team/leave"),
    ("POST", f"{NS}{MEMBERS}/remove"): Entry(
        changes_its_own, 303, f"{N}/team/members/{{member}}/remove"
    ),
    ("POST", f"{NS}{MEMBERS}/captain"): Entry(
        changes_its_own, 303, f"{N}/team/members/{{member}}/captain"
    ),
    ("POST", f"{NS}{ENTRIES}/withdraw"): Entry(
        changes_its_own, 303, f"{N}/team/entries/{{entry}}/withdraw"
    ),
    ("POST", f"{NS}{ENTRIES}/choose"): Entry(
        changes_its_own, 303, f"{N}/team/entries/{{entry}}/choose"
    ),
}
U, US = "/admin/users/{user}", "/admin/users/<row:user_id>"
API_U, API_US = "/api/v1/admin/users/{user}", "/api/v1/admin/users/<int:user_id>"
REJUDGEMENTS, API_R = "/admin/rejudgements", "/api/v1/admin/rejudgements"
ROW, ID, THIS = "<row:rejudgement_id>", "<int:rejudgement_id>", "{rejudgement}"
ADMIN: dict[tuple[str, str], Entry] = {
    ("GET", "/admin/"): Entry(administers),
    ("GET", "/admin/workers"): Entry(administers),
    ("POST", "/admin/workers/drain"): Entry(administers, 303),
    ("POST", "/admin/workers/resume"): Entry(administers, 303),
    ("GET", "/admin/queue"): Entry(administers),
    ("POST", "/admin/queue/cancel"): Entry(administers, 404),
    ("GET", "/admin/storage"): Entry(administers),
    ("POST", "/admin/storage/retention"): Entry(administers, 303),
    ("GET", "/admin/users"): Entry(administers),
    ("GET", US): Entry(administers, path=U),
    ("POST", US): Entry(administers, 303, U),
    ("POST", f"{US}/disable"): Entry(administers, 303, f"{U}/disable"),
    ("POST", f"{US}/enable"): Entry(administers, 303, f"{U}/enable"),
    ("POST", f"{US}/revoke"): Entry(administers, 303, f"{U}/revoke"),
    ("POST", f"{US}/reset"): Entry(administers, path=f"{U}/reset"),
    ("POST", f"{US}/delete"): Entry(administers, 422, f"{U}/delete"),
    ("GET", "/admin/audit"): Entry(administers),
    ("GET", REJUDGEMENTS): Entry(administers),
    ("GET", f"{REJUDGEMENTS}/new"): Entry(administers),
    ("POST", REJUDGEMENTS): Entry(administers, 422),
    ("GET", f"{REJUDGEMENTS}/{ROW}"): Entry(administers, path=f"{REJUDGEMENTS}/{THIS}"),
    ("POST", f"{REJUDGEMENTS}/{ROW}/accept"): Entry(
        administers, 303, f"{REJUDGEMENTS}/{THIS}/accept"
    ),
    ("POST", f"{REJUDGEMENTS}/{ROW}/discard"): Entry(
        administers, 303, f"{REJUDGEMENTS}/{THIS}/discard"
    ),
    ("GET", API_R): Entry(administers),
    ("GET", f"{API_R}/preview"): Entry(administers, path=f"{API_R}/preview?benchmark=currents-v1"),
    ("POST", API_R): Entry(
        administers, 409, options={"json": {"benchmark": "nothing", "reason": "Why"}}
    ),
    ("GET", f"{API_R}/{ID}"): Entry(administers, path=f"{API_R}/{THIS}"),
    ("GET", f"{API_R}/{ID}/differences"): Entry(administers, path=f"{API_R}/{THIS}/differences"),
    ("GET", f"{API_R}/{ID}/differences.csv"): Entry(
        administers, path=f"{API_R}/{THIS}/differences.csv"
    ),
    ("POST", f"{API_R}/{ID}/accept"): Entry(administers, path=f"{API_R}/{THIS}/accept"),
    ("POST", f"{API_R}/{ID}/discard"): Entry(administers, path=f"{API_R}/{THIS}/discard"),
    ("GET", "/api/v1/admin/overview"): Entry(administers),
    ("GET", "/api/v1/admin/workers"): Entry(administers),
    ("PATCH", "/api/v1/admin/workers/<string:worker>"): Entry(
        administers, 404, "/api/v1/admin/workers/w1@host", {"json": {"drained": True}}
    ),
    ("GET", "/api/v1/admin/queue"): Entry(administers),
    ("GET", "/api/v1/admin/storage"): Entry(administers),
    ("POST", "/api/v1/admin/storage/retention"): Entry(administers, 202),
    ("GET", "/api/v1/admin/users"): Entry(administers),
    ("GET", API_US): Entry(administers, path=API_U),
    ("PATCH", API_US): Entry(administers, path=API_U, options={"json": {"quota_day": None}}),
    ("POST", f"{API_US}/revoke"): Entry(administers, 204, f"{API_U}/revoke"),
    ("POST", f"{API_US}/reset-link"): Entry(administers, 200, f"{API_U}/reset-link"),
    ("DELETE", API_US): Entry(administers, 404, "/api/v1/admin/users/1000000"),
    ("GET", "/api/v1/admin/audit"): Entry(administers),
}
OPEN = Entry(everybody)
ROUTES: dict[tuple[str, str], Entry] = {
    ("GET", "/metrics"): OPEN,  # first: after all the others it has thousands of series
    ("GET", "/static/<path:filename>"): Entry(everybody, path="/static/logo.svg"),
    ("GET", "/"): OPEN,
    ("GET", "/submit/"): Entry(everybody, 302),
    ("GET", "/submit/<name>"): Entry(everybody, path="/submit/currents-v1"),
    ("POST", "/submit/<name>"): Entry(submits, 303, "/submit/currents-v1", {"data": FORM}),
    ("GET", "/first-controller"): OPEN,
    ("GET", "/demo"): OPEN,
    ("POST", "/demo"): Entry(submits, 303),
    **{
        ("GET", f"/api/v1/demo/{name}"): OPEN
        for name in ("series.json", "moments.json", "scene.json", "texture.jpg", "camera.jpg")
    },
    ("GET", "/benchmarks/"): OPEN,
    ("GET", "/benchmarks/<name>"): Entry(everybody, path="/benchmarks/currents-v1"),
    ("GET", "/runs/<row:run_id>"): Entry(reads_run, path="/runs/{run}"),
    ("GET", "/runs/<row:run_id>/embed"): Entry(reads_run, path="/runs/{run}/embed"),
    **_changing(
        "/runs/", "<row:run_id>", 303, **ACTIONS, **REVEAL, **VERIFY, **DELETE_DATA, **EDIT
    ),
    ("GET", "/p/<row:run_id>"): Entry(everybody, 404, "/p/{run}"),  # it was never public
    ("GET", "/runs/<row:run_id>/publish"): Entry(
        changes_run, path="/runs/{run}/publish", run="recorded"
    ),
    ("POST", "/runs/<row:run_id>/publish"): Entry(
        changes_run, 303, "/runs/{run}/publish", {"data": METHOD}, run="recorded"
    ),
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
    ("GET", "/forgot"): OPEN,
    ("POST", "/forgot"): Entry(everybody, options={"data": {"address": "a@b.example"}}),
    ("GET", "/mail/confirm"): OPEN,
    ("POST", "/mail/confirm"): Entry(everybody, 422, options={"data": WRONG}),
    ("POST", "/account/mail"): Entry(changes_password, 422, options={"data": WRONG}),
    ("POST", "/account/mail/remove"): Entry(changes_password, 303),
    ("POST", "/account/mail/notify"): Entry(changes_tokens, 303),
    ("GET", "/api/v1/me/mail"): Entry(reads_account),
    ("PATCH", "/api/v1/me/mail"): Entry(changes_tokens, options={"json": {"notify_minutes": None}}),
    ("GET", "/sign-in/provider"): Entry(everybody, 503),  # there is no provider
    ("GET", "/sign-in/callback"): Entry(everybody, 503),
    ("GET", "/sign-up/provider"): Entry(everybody, 302),
    ("POST", "/sign-up/provider"): Entry(everybody, 303),
    ("GET", "/account/identity"): Entry(changes_password, 302),
    ("POST", "/account/identity"): Entry(changes_password, 303),
    ("POST", "/account/identity/unlink"): Entry(changes_password, 422),  # it has no password
    ("GET", "/reset"): OPEN,
    ("POST", "/reset"): Entry(everybody, 422, options={"data": WRONG}),
    ("POST", "/password"): Entry(changes_password, 422, options={"data": {"new": "short"}}),
    ("GET", "/invitations"): Entry(invites),
    ("POST", "/invitations"): Entry(invites, options={"data": {"count": "2"}}),
    **CLASSES,
    **COMPETITIONS,
    **COMPETITION_PAGES,
    **ADMIN,
    ("GET", "/docs/"): Entry(everybody, 302),
    ("GET", "/docs/search"): Entry(everybody),
    ("GET", "/docs/<name>"): Entry(everybody, path="/docs/start"),
    ("GET", "/docs/guides/<path:name>"): Entry(everybody, path="/docs/guides/benchmarks.md"),
    ("GET", "/docs/physics/<name>.urdf"): Entry(everybody, path="/docs/physics/girona500.urdf"),
    ("GET", "/download/<name>"): Entry(
        everybody, path=f"/download/{own_wheel.file_name('seamark')}"
    ),
    ("GET", "/status"): OPEN,
    ("GET", "/problems"): OPEN,
    ("GET", "/problems/<slug>"): Entry(everybody, path="/problems/not-found"),
    ("GET", "/healthz"): OPEN,
    ("GET", "/readyz"): Entry(everybody, 503),  # there is no worker
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
    ("GET", "/api/v1/foxglove-layout.json"): OPEN,
    ("GET", "/api/v1/me"): OPEN,
    ("GET", "/api/v1/me/data.zip"): Entry(reads_account),
    ("GET", "/api/v1/runs"): Entry(lists),
    ("POST", "/api/v1/runs"): Entry(submits, 202, options=ORDER),
    ("GET", "/api/v1/rosbridge"): Entry(connects, 426, "/api/v1/rosbridge?benchmark=currents-v1"),
    ("GET", "/logs/new"): Entry(uploads),
    ("POST", "/logs/new"): Entry(uploads, 422),
    ("POST", "/api/v1/logs"): Entry(uploads, 422, options=MULTIPART),
    ("POST", "/api/v1/checks"): Entry(uploads, 422, options=UPLOAD),  # there is no worker
    ("GET", "/api/v1/checks/<int:check_id>"): Entry(reads_its_own, path="/api/v1/checks/{check}"),
    ("GET", "/api/v1/checks/<int:check_id>/camera.jpg"): Entry(
        reads_its_own, 404, "/api/v1/checks/{check}/camera.jpg"
    ),  # it is queued: there is no image yet
    **_reading("", "/events", "/telemetry.csv", "/telemetry.f64", "/series.json", "/metrics.json"),
    **_reading(*(f"/{kind.file}" for kind in FORMATS.values() if kind.converted)),
    **_reading("/manifest.json", "/config.json", "/log", "/program", "/camera.jpg", "/dataset.zip"),
    **_reading("/scene.json", "/texture.jpg", "/moments.json", "/recognition.json"),
    ("GET", "/api/v1/runs/<int:run_id>/vehicle.toml"): Entry(
        reads_run, path="/api/v1/runs/{run}/vehicle.toml", run="own vehicle"
    ),
    ("GET", "/api/v1/runs/<int:run_id>/parts/<role>"): Entry(
        reads_run, path="/api/v1/runs/{run}/parts/tracker", run="own tracker"
    ),
    ("POST", "/api/v1/vehicles/check"): Entry(uploads, options=VEHICLE_FILE),
    ("GET", "/compare"): Entry(reads_run, path="/compare?runs={run},{other}"),
    ("GET", "/compare/preview.jpg"): Entry(
        reads_run, path="/compare/preview.jpg?runs={run},{other}"
    ),
    ("GET", "/runs/<row:run_id>/preview.jpg"): Entry(reads_run, path="/runs/{run}/preview.jpg"),
    ("GET", "/preview.jpg"): OPEN,
    ("GET", "/benchmarks/<name>/preview.jpg"): Entry(
        everybody, path="/benchmarks/currents-v1/preview.jpg"
    ),
    ("GET", "/leaderboards/<name>/preview.jpg"): Entry(
        everybody, path="/leaderboards/currents-v1/preview.jpg"
    ),
    ("GET", "/api/v1/compare"): Entry(reads_run, path="/api/v1/compare?runs={run},{other}"),
    **_changing("/api/v1/runs/", "<int:run_id>", 200, **ACTIONS, **REVEAL),
    ("POST", "/api/v1/runs/<int:run_id>/publish"): Entry(
        changes_run, 200, "/api/v1/runs/{run}/publish", {"json": METHOD}, run="recorded"
    ),
    **_changing("/api/v1/runs/", "<int:run_id>", 202, **RERUN),
    **_changing("/api/v1/runs/", "<int:run_id>", 409, **VERIFY),  # it is a practice run
    **{  # they are of public runs, and this one is private
        ("GET", f"/api/v1/runs/<int:run_id>/{name}"): Entry(
            everybody, 404, f"/api/v1/runs/{{run}}/{name}"
        )
        for name in ("publication", "citation.bib", "citation.cff", "badge.svg")
    },
    ("GET", "/api/v1/runs/<int:run_id>/recomputations"): Entry(
        reads_run, path="/api/v1/runs/{run}/recomputations"
    ),
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
