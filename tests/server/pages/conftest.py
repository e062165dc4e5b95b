"""A site with a cast: ann owns, ben must see nothing, root is the admin, a guest has a cookie."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import pytest
from flask import Flask
from flask.testing import FlaskClient
from werkzeug.test import TestResponse

from seamark.server.accounts import accounts
from seamark.server.accounts.permissions import Viewer
from seamark.server.app import create_app
from seamark.server.database.engine import Database
from seamark.server.runs import door as runs
from seamark.server.settings import Settings
from seamark.server.web import authentication

CAST = ("ann", "ben", "root")
_SECRET = re.compile(r'name="csrf_token" value="([^"]+)"')


@dataclass
class Browser:
    """A browser that keeps its cookie and sends the form's secret as a page's form does."""

    client: FlaskClient

    def get(self, path: str, **options: Any) -> TestResponse:
        return self.client.get(path, **options)

    def post(self, path: str, data: dict[str, Any] | None = None, **options: Any) -> TestResponse:
        return self.client.post(path, data={"csrf_token": self.secret(), **(data or {})}, **options)

    def secret(self) -> str:
        found = _SECRET.search(self.client.get("/sign-in").text)
        assert found is not None
        return found.group(1)


@dataclass
class Site:
    """The application with its database, and the few things that most tests do to it."""

    app: Flask
    database: Database
    settings: Settings
    viewers: dict[str, Viewer]

    def browser(self, name: str = "stranger") -> Browser:
        client = self.app.test_client()
        if name in self.viewers:
            with client.session_transaction() as session:
                user_id = self.viewers[name].user_id
                assert user_id is not None
                with self.app.app_context():
                    session.update(authentication.cookie_of(user_id))
        return Browser(client)

    def queue(self, name: str = "ann", kind: str = "practice", **wishes: Any) -> int:
        order = {"benchmark": "currents-v1", "config": {}, "controller": "pi"} | wishes
        order["kind"] = runs.Kind(kind)
        with self.database.writing() as session:
            order = runs.Order(viewer=self.viewers[name], **order)
            return runs.enqueue(session, order, self.settings)

    def claim(self) -> runs.Claim:
        with self.database.writing() as session:
            claim = runs.claim(session, "w1", languages=("python",), settings=self.settings)
        assert claim is not None
        return claim

    def end(self, claim: runs.Claim, **changes: Any) -> None:
        score = {"score": 50.0, "score_low": 45.0, "score_high": 55.0, "level_held": 0.2}
        report = {"state": runs.RunState.SUCCEEDED, "metrics": score, "digest": "0" * 64}
        with self.database.writing() as session:
            assert runs.finish(session, claim, runs.Report(**(report | changes)))

    def finished(self, name: str = "ann", *, public: bool = False, **wishes: Any) -> int:
        run_id = self.queue(name, **wishes)
        self.end(self.claim())
        if public:
            self.publish(run_id)
        return run_id

    def failed(self, name: str = "ann", **detail: Any) -> int:
        run_id = self.queue(name)
        failure = {"state": runs.RunState.FAILED, "cause": "user_error", "metrics": None}
        self.end(self.claim(), **failure, digest=None, detail=detail)
        return run_id

    def publish(self, run_id: int) -> None:
        with self.database.writing() as session:
            assert runs.publish(session, run_id)

    def show(self, run_id: int) -> runs.RunView:
        with self.database.reading() as session:
            view = runs.show(session, run_id, self.settings)
        assert view is not None
        return view


@pytest.fixture
def site(settings: Settings, database: Database) -> Iterator[Site]:
    app = create_app(settings)
    with database.writing() as session:
        users = [accounts.sign_up(session, n, None, is_admin=n == "root") for n in CAST]
    viewers = {u.name: Viewer(user_id=u.id, name=u.name, is_admin=u.is_admin) for u in users}
    yield Site(app, database, settings, viewers)
    app.extensions["seamark"].close()
