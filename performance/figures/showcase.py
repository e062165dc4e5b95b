"""A service with something on every page: people, programs, runs, a sweep and a class."""

import secrets
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sqlalchemy import func, select

from performance.figures.tutorial import programs
from performance.service.database.requests import pages
from seamark.client import Client
from seamark.server.accounts import accounts
from seamark.server.accounts.permissions import Role
from seamark.server.app import create_app
from seamark.server.classes import assignments, classrooms
from seamark.server.classes.assignments import Draft
from seamark.server.database.engine import Database
from seamark.server.database.tables import Run, User
from seamark.server.runs.publication import publications
from seamark.server.runs.publication.publications import Terms
from seamark.server.runs.record.states import LIVE
from seamark.server.settings import Settings
from tests.services.embedded import cancel_baselines, started

TEACHER, PUPILS = "ada", ("bruno", "chiara", "dmitri")
BENCHMARK, SEED = "currents-v1", 2026
SHORT = {"levels": [0.0, 0.2, 0.4], "level_duration_s": 40.0, "settle_s": 5.0}
SWEEP = {"kp": "0.2, 0.4, 0.6", "ki": "0, 0.02, 0.05"}
BROKEN = """class Controller:
    def __init__(self, config):
        self.gain = 1.0

    def reset(self, level):
        pass

    def step(self, observation):
        return [observation.error[0] / (observation.t - 10.0), 0.0, 0.0, 0.0]
"""
INSTRUCTIONS = """Hold the vehicle above the box in three currents.

Start from the example controller, find gains with a sweep, then write a program of your own."""
WEEK_S = 7 * 86400.0
POLL_S = 1.0


@dataclass(frozen=True)
class Showcase:
    """A running service, the account that sees all of it, and its pages."""

    address: str
    name: str
    password: str  # of all accounts
    paths: list[str]


@contextmanager
def showcase() -> Iterator[Showcase]:
    """Start a service on a folder of its own, and give it once all runs have ended."""
    with tempfile.TemporaryDirectory(prefix="seamark-showcase-") as folder:
        data = Path(folder) / "data"
        with started(data, quota_live="50") as (address, _):
            with closing(Database(f"sqlite:///{data / 'seamark.db'}")) as database:
                cancel_baselines(database)
                password = secrets.token_urlsafe(12)
                made = _fill(database, _people(database, password), address, Path(folder))
            yield Showcase(address, TEACHER, password, _paths(data, *made))


def _fill(
    database: Database, tokens: Mapping[str, str], address: str, folder: Path
) -> tuple[int, int, int]:
    """Return a run of the teacher, a failed one, and one on the leaderboard."""
    sources = list(programs().items())
    files = [folder / f"{title}.py" for title, _ in [*sources, ("broken", "")]]
    for file, (_, source) in zip(files, [*sources, ("broken", BROKEN)], strict=True):
        file.write_text(source, encoding="utf-8")
    with Client(address, tokens[TEACHER]) as client:
        own = _submit(
            client, program=files[2], config=SHORT, seed=SEED, title="Observer, first try"
        )
        failed = _submit(client, program=files[-1], config=SHORT, seed=SEED)
        client.sweep(BENCHMARK, SWEEP, controller="pi", config=SHORT, seed=SEED)
    ranked = []
    for name, file, (title, _) in zip(PUPILS, files, sources, strict=False):
        with Client(address, tokens[name]) as client:
            _submit(client, program=file, assignment=1, title=title)
            ranked.append(_submit(client, program=file, kind="ranked", title=title))
    wait_for_runs(database)
    with database.writing() as session:
        for run_id, (title, _) in zip(ranked, sources, strict=False):
            publications.publish(session, run_id, Terms(method=title))
    return own, failed, ranked[-1]


def _people(database: Database, password: str) -> dict[str, str]:
    """Create the accounts and the class; return name -> token."""
    tokens = {}
    with database.writing() as session:
        for name in (TEACHER, *PUPILS):
            role = Role.ADMIN if name == TEACHER else Role.USER
            user = accounts.sign_up(session, name, password, role=role)
            scopes = ("read", "submit")
            tokens[name] = accounts.new_token(session, user.id, "laptop", scopes)
            if name == TEACHER:
                class_id = classrooms.create(session, user.id, "Marine robotics, winter term")
            elif (room := classrooms.find(session, class_id)) is not None:
                classrooms.join(session, user.id, room.code)
        draft = Draft(
            title="Hold station",
            benchmark=BENCHMARK,
            instructions=INSTRUCTIONS,
            config=SHORT,
            seed=SEED,
            deadline=time.time() + WEEK_S,
        )
        assignments.create(session, class_id, draft, trials_max=1)
    return tokens


def _submit(client: Client, **run: Any) -> int:
    return client.submit(BENCHMARK, **run).id


def wait_for_runs(database: Database) -> None:
    """Wait until all runs have ended."""
    live = select(func.count()).where(Run.state.in_(LIVE))
    while True:
        with database.reading() as session:
            if not session.scalar(live):
                return
        time.sleep(POLL_S)


def _paths(data: Path, own: int, failed: int, ranked: int) -> list[str]:
    """Return the pages of the routes, and those that look different with other rows."""
    values = {"data": data, "secret_key": "x", "broker_url": "redis://127.0.0.1:1/0"}
    app = create_app(Settings.model_validate(values))
    services = app.extensions["seamark"]
    with services.database.reading() as session:
        user_id = session.scalars(select(User.id).where(User.name == PUPILS[-1])).one()
    of_routes = pages(app, run_id=own, user=PUPILS[-1], user_id=user_id)
    services.close()
    more = (f"/leaderboards/{BENCHMARK}", f"/runs/{ranked}", f"/runs/{failed}", "/nowhere")
    return [*of_routes, *more]
