"""Every page and every resource of the API that can be read, from the application's own routes."""

from base64 import b64decode
from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from typing import Any
from urllib.parse import quote

from flask import Flask
from sqlalchemy import select, update
from sqlalchemy.orm import Session

from seamark.competitions import document
from seamark.server.classes import assignments, classrooms
from seamark.server.classes.assignments import Draft
from seamark.server.competitions import competitions, teams
from seamark.server.database.class_tables import Classroom
from seamark.server.database.competition_tables import (
    Competition,
    Entry,
    FinalPlace,
    Round,
    Team,
)
from seamark.server.database.rejudgement_tables import Rejudgement
from seamark.server.database.submission_tables import Sweep
from seamark.server.database.tables import Run
from seamark.server.runs.record.states import RunKind, RunState

BENCHMARK = "currents-v2"
_CODE = "0123456789"  # of the first class, and of a team
# A white pixel, as PNG.
_PICTURE = b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAAAAAA6fptVAAAACklEQVR4nGP4DwABAQEAsTj2FAAAAABJRU5ErkJggg=="
)
# Rule with variables -> its address; {run} is the number of a run with files.
_ADDRESSES = {
    "/static/<path:filename>": "/static/logo.svg",
    "/submit/<name>": f"/submit/{BENCHMARK}",
    "/benchmarks/<name>": f"/benchmarks/{BENCHMARK}",
    "/benchmarks/<name>/preview.jpg": f"/benchmarks/{BENCHMARK}/preview.jpg",
    "/leaderboards/<name>": f"/leaderboards/{BENCHMARK}",
    "/leaderboards/<name>/preview.jpg": f"/leaderboards/{BENCHMARK}/preview.jpg",
    "/users/<name>": "/users/{user}",
    "/classes/join/<code>": f"/classes/join/{_CODE}",
    "/api/v1/users/<string:name>": "/api/v1/users/{user}",
    "/docs/<name>": "/docs/start",
    "/docs/guides/<path:name>": "/docs/guides/benchmarks.md",
    "/docs/physics/<name>.urdf": "/docs/physics/girona500.urdf",
    "/problems/<slug>": "/problems/not-found",
    "/api/v1/benchmarks/<string:benchmark>": f"/api/v1/benchmarks/{BENCHMARK}",
    "/api/v1/leaderboards/<string:benchmark>": f"/api/v1/leaderboards/{BENCHMARK}",
    "/api/v1/runs/<int:run_id>/parts/<role>": "/api/v1/runs/{run}/parts/tracker",
    "/api/v1/checks/<int:check_id>": "/api/v1/checks/1",
    "/api/v1/checks/<int:check_id>/camera.jpg": "/api/v1/checks/1/camera.jpg",
    "/api/v1/admin/rejudgements/preview": (
        f"/api/v1/admin/rejudgements/preview?benchmark={BENCHMARK}&other_code=true"
    ),
}
# An open competition, a draft, and a decided one.
_CUP, _DRAFT, _DECIDED = "first-cup-v1", "first-cup-v2", "first-cup-v3"
_OF_DECIDED = ("/results", "/archive.zip", "/certificates/")
_OF_COMPETITION = {
    "<name>": _CUP,
    "<string:name>": _CUP,
    "<row:team_id>": "3",  # of the decided one
    "<int:number>": "1",
    "<code>": _CODE,
}
_RUN = ("<row:run_id>", "<int:run_id>")
_USER = ("<row:user_id>", "<int:user_id>")
_FIRST = tuple(  # the rows of `create_first`
    f"<{kind}:{name}_id>"
    for kind in ("row", "int")
    for name in ("class", "assignment", "sweep", "rejudgement")
)
# With what slows down lists: filters, and pages far from the start.
_MORE = (
    f"/competitions/{_CUP}?per=method",
    f"/competitions/{_DRAFT}",
    f"/submit/{BENCHMARK}?competition={_CUP}",
    "/compare?runs={run}",
    f"/admin/rejudgements/new?benchmark={BENCHMARK}",
    f"/admin/rejudgements/new?benchmark={BENCHMARK}&language=octave&worker=none&from=2020-01-01",
    f"/admin/rejudgements/new?benchmark={BENCHMARK}&other_code=on&version=0",
    "/runs/?of=all",
    "/runs/?of=all&state=failed",
    "/runs/?of=all&state=cancelled",
    "/runs/?of=all&user=many5",
    "/runs/?state=failed",
    "/runs/?of=all&sort=highest",
    "/runs/?of=all&sort=title&q=no+such+words",
    "/runs/?sort=oldest&q=gain",
    "/api/v1/runs?which=all&state=failed&state=cancelled&kind=ranked",
    "/api/v1/runs?which=public&benchmark=visibility-v2&kind=ranked&limit=200",
    "/api/v1/runs?which=all&limit=200&after={run}",
    "/api/v1/leaderboards/currents-v2?limit=500",
    "/leaderboards/currents-v2?after={half}",
    "/leaderboards/currents-v2?per=method&after={half}",
    "/leaderboards/currents-v2?language=python&after={half}",
    "/leaderboards/currents-v2?baselines=only",
    "/leaderboards/currents-v2?sort=power_share",
)
_WHOLE_FILES = frozenset({"/runs/runs.csv", "/download/<name>"})  # all rows; the wheel, built once
_NOT_PAGES = ("/api/v1", "/static", "/metrics", "/healthz", "/readyz")
_FILES = (".jpg", ".urdf", ".csv", ".zip", ".svg", "audit.json", "/picture")
# Pages of a service with e-mail or an identity provider, which this one has not.
_ELSEWHERE = ("/account/identity", "/forgot", "/mail/", "/sign-in/", "/sign-up/")


def create_first(session: Session, user_id: int) -> None:
    """Create the first of each thing that `addresses` names by its number."""
    class_id = classrooms.create(session, user_id, "Marine robotics")
    session.get_one(Classroom, class_id).code = _CODE
    draft = Draft(title="Hold position", benchmark=BENCHMARK, config={})
    assignments.create(session, class_id, draft, trials_max=1)
    axes = [{"name": "kp", "values": [0.2, 0.4]}]
    session.add(Sweep(user_id=user_id, benchmark=BENCHMARK, axes=axes, created_at=0.0))
    again = {"reason": "A bug in the drag", "chosen": {}, "created_by": "root", "created_at": 0.0}
    session.add(Rejudgement(benchmark=BENCHMARK, **again))
    _create_competitions(session, user_id)


def _create_competitions(session: Session, user_id: int) -> None:
    """Make an open competition, in which this account has a team, and a draft."""
    begin = datetime.now(UTC) - timedelta(days=1)
    values: dict[str, Any] = {
        "title": "Harbour Cup",
        "question": "Who keeps station in a harbour?",
        "rules": "Be fair.",
        "benchmark": BENCHMARK,
        "settings": {"levels": [0.0, 0.2]},
        "rounds": [
            {
                "kind": "qualification",
                "opens": begin.isoformat(),
                "closes": (begin + timedelta(days=300)).isoformat(),
                "trials": 4,
            }
        ],
    }
    for name in (_CUP, _DRAFT, _DECIDED):
        asked = competitions.prepared(document.read(values | {"name": name}), None)
        made = competitions.create(
            *(session, user_id, asked), picture=_PICTURE, vehicle=None, secret=b"secret"
        )
        if name == _CUP:  # the organiser takes no part, so it is nobody
            row = session.get_one(Competition, made)
            row.opened_at, row.organiser_id = begin.timestamp(), None
            teams.found(session, competitions.get(session, made), user_id, "Kelp")
            empty = Team(competition_id=made, name="Wrack", name_key="wrack", code=_CODE)
            empty.created_at = begin.timestamp()
            session.add(empty)
        if name == _DECIDED:
            _decide(session, made, user_id, begin.timestamp())


def _decide(session: Session, competition_id: int, user_id: int, at: float) -> None:
    """Let the competition be decided, with one place."""
    of: dict[str, Any] = {"method": "PI", "score": 50.0, "score_low": 45.0, "score_high": 55.0}
    team = Team(competition_id=competition_id, name="Kelp", name_key="kelp", code=_CODE[::-1])
    team.captain_id, team.created_at = user_id, at
    run = Run(owner="team:3", benchmark=BENCHMARK, kind=RunKind.ENTRY, config={}, seed=1, trials=4)
    run.controller, run.state, run.queued_at, run.finished_at = "pi", RunState.SUCCEEDED, at, at
    run.public, run.data_deleted_at = True, at
    session.add_all((team, run))
    session.flush()
    row = session.get_one(Competition, competition_id)
    row.opened_at = row.ended_at = at
    session.execute(update(Round).where(Round.competition_id == row.id).values(decided_at=at))
    decided = (Round.competition_id == row.id, Round.number == 1)
    round_id = session.scalars(select(Round.id).where(*decided)).one()
    of |= {"round_id": round_id, "run_id": run.id, "team_id": team.id}
    session.add(Entry(method_key="pi", submitted_at=at, **of))
    session.add(FinalPlace(place=1, place_low=1, place_high=1, trials=4, **of))
    session.flush()


def _of_competition(rule: str) -> str:
    """Return a rule with the names of a competition and a team, if it has variables for them."""
    if "/competitions/<" in rule:
        for variable, text in _OF_COMPETITION.items():
            decided = any(part in rule for part in _OF_DECIDED)
            name = _DECIDED if decided else _DRAFT if "/change" in rule else text
            rule = rule.replace(variable, name if text == _CUP else text)
    return rule


def addresses(
    app: Flask, *, run_id: int, half: str, user: str = "many5", user_id: int = 1
) -> Iterator[str]:
    """Yield the addresses of all routes that answer GET; raises KeyError for an unknown variable.

    Parameters
    ----------
    run_id
        A run that ended, with files.
    half
        A cursor in the middle of the leaderboard.
    user
        Somebody with a published run.
    user_id
        Somebody with an account, whom an admin looks at.
    """
    numbers = dict.fromkeys(_FIRST, 1) | dict.fromkeys(_RUN, run_id) | dict.fromkeys(_USER, user_id)
    for rule in app.url_map.iter_rules():
        if "GET" not in (rule.methods or ()) or rule.rule in _WHOLE_FILES:
            continue
        address = _ADDRESSES.get(rule.rule) or _of_competition(rule.rule)
        for variable, number in numbers.items():
            address = address.replace(variable, str(number))
        if "<" in address:
            raise KeyError(
                f"performance/service/database/requests.py has no address for {rule.rule}"
            )
        yield address.format(run=run_id, user=user)
    for address in _MORE:
        yield address.format(run=run_id, half=quote(half))  # a + would become a space


def pages(app: Flask, *, run_id: int, user: str, user_id: int) -> list[str]:
    """Return the addresses of all pages that a browser can open, in alphabetical order."""
    lists = ("/leaderboards/", "/runs/?")  # once each is enough for what they look like
    paths = {
        path
        for path in addresses(app, run_id=run_id, half="", user=user, user_id=user_id)
        if not path.startswith((*_NOT_PAGES, *_ELSEWHERE)) and not path.endswith(_FILES)
    }
    return sorted(path for path in paths if not (path.startswith(lists) and "?" in path))
