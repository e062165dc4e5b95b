"""A cast for the tests of the server's core, on both databases."""

from collections.abc import Iterator
from dataclasses import dataclass

import pytest

from seamark.server.accounts import accounts
from seamark.server.accounts.permissions import Viewer
from seamark.server.database.engine import Database
from seamark.server.database.schema import upgrade
from seamark.server.runs import door as runs
from seamark.server.settings import Settings


@pytest.fixture(params=["sqlite", "postgresql"])
def both(request: pytest.FixtureRequest, settings: Settings) -> Iterator["Service"]:
    """A service on each of the two databases."""
    if request.param == "postgresql":
        url = request.getfixturevalue("postgres_url")
        settings = settings.model_copy(update={"database_url": url})
    upgrade(settings)
    database = Database(settings.database_url)
    yield Service(database, settings)
    database.close()


@dataclass(frozen=True)
class Service:
    """A database with settings, and the few things that most tests do to it."""

    database: Database
    settings: Settings

    def user(self, name: str) -> Viewer:
        with self.database.writing() as session:
            user = accounts.sign_up(session, name, None)
            return Viewer(user_id=user.id, name=user.name)

    def queue(self, viewer: Viewer, **wishes: object) -> int:
        order = {"benchmark": "currents-v1", "config": {}, "controller": "pi"} | wishes
        with self.database.writing() as session:
            return runs.enqueue(session, runs.Order(viewer=viewer, **order), self.settings)

    def claim(self, worker: str = "w1", languages: tuple[str, ...] = ()) -> runs.Claim | None:
        with self.database.writing() as session:
            return runs.claim(session, worker, languages=languages, settings=self.settings)

    def show(self, run_id: int) -> runs.RunView:
        with self.database.reading() as session:
            view = runs.show(session, run_id, self.settings)
        assert view is not None
        return view

    def finish(self, claim: runs.Claim, score: float = 50.0, **changes: object) -> bool:
        metrics = {"score": score, "score_low": score - 5, "score_high": score + 5}
        report = {"state": runs.RunState.SUCCEEDED, "metrics": metrics, "digest": "0" * 64}
        with self.database.writing() as session:
            return runs.finish(session, claim, runs.Report(**(report | changes)))
