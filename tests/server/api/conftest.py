"""An application with a cast: ann owns, ben must see nothing, root is the admin; their tokens."""

import io
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest
from flask import Flask
from flask.testing import FlaskClient
from sqlalchemy import select
from werkzeug.test import TestResponse

from seamark.server.accounts import accounts
from seamark.server.accounts.permissions import Viewer
from seamark.server.app import create_app
from seamark.server.checks import queue
from seamark.server.database.engine import Database
from seamark.server.database.tables import Run
from seamark.server.programs import store
from seamark.server.runs import door as runs
from seamark.server.runs.files import RunFiles
from seamark.server.runs.states import RunState
from seamark.server.settings import Settings
from seamark.server.web.services import Services
from seamark.sim.recording.telemetry import INDEX, WIDTH

PROGRAM = b"""
class Controller:
    def __init__(self, config): ...
    def step(self, observation): ...
"""
ROLES = {  # role -> account, scopes, days
    "other": ("ben", ("read", "submit"), 1.0),
    "owner": ("ann", ("read", "submit"), 1.0),
    "admin": ("root", ("read", "submit", "admin"), 1.0),
    "reader": ("ann", ("read",), 1.0),
    "submitter": ("ann", ("submit",), 1.0),
    "expired": ("ann", ("read", "submit"), -1.0),
}


@dataclass
class Site:
    """The application with its database, and the few things that most tests do to it."""

    app: Flask
    database: Database
    settings: Settings
    viewers: dict[str, Viewer]
    tokens: dict[str, str] = field(default_factory=dict)

    @property
    def held(self) -> Services:
        services: Services = self.app.extensions["seamark"]
        return services

    def client(self) -> FlaskClient:
        return self.app.test_client()

    def call(self, role: str, method: str, path: str, **options: Any) -> TestResponse:
        token = self.tokens.get(role)
        headers = {"Authorization": f"Bearer {token}"} if token else {}
        headers |= options.pop("headers", {})
        return self.client().open(path, method=method, headers=headers, **options)

    def queue(self, name: str = "ann", **wishes: Any) -> int:
        order = {"benchmark": "currents-v1", "config": {}, "controller": "pi"} | wishes
        with self.database.writing() as session:
            order = runs.Order(viewer=self.viewers[name], **order)
            return runs.enqueue(session, order, self.settings)

    def clear_line(self) -> None:
        """Cancel what waits, so that the next run to be claimed is the next one queued."""
        with self.database.writing() as session:
            waiting = select(Run.id).where(Run.state == RunState.QUEUED)
            for run_id in list(session.scalars(waiting)):
                runs.request_cancel(session, run_id)

    def upload(self) -> int:
        data, limit = self.settings.data, self.settings.upload_max_bytes
        program = store.store(io.BytesIO(PROGRAM), "mine.py", limit=limit, data=data)
        return self.queue(controller="upload", program=program)

    def check(self, name: str = "ann") -> int:
        """Order a check that nobody carries out."""
        limit, data = self.settings.upload_max_bytes, self.settings.data
        program = store.store(io.BytesIO(PROGRAM), "mine.py", limit=limit, data=data)
        user_id = self.viewers[name].user_id
        assert user_id is not None
        with self.database.writing() as session:
            return queue.order(session, user_id, "currents-v1", {}, program)

    def end(self, **changes: Any) -> None:
        with self.database.writing() as session:
            claim = runs.claim(session, "w1", languages=("python",), settings=self.settings)
        assert claim is not None
        metrics = {"score": 50.0, "score_low": 45.0, "score_high": 55.0, "level_held": 0.2}
        manifest = {"seed": 7, "trials": [{"seed": 9}]}
        report = {"state": RunState.SUCCEEDED, "metrics": metrics, "manifest": manifest}
        with self.database.writing() as session:
            assert runs.finish(
                session, claim, runs.Report(**(report | {"digest": "0" * 64} | changes))
            )

    def finished(self, *, public: bool = False) -> int:
        run_id = self.upload()
        self.end()
        self.record(run_id, rows=40)
        if public:
            with self.database.writing() as session:
                assert runs.publish(session, run_id)
        return run_id

    def record(self, run_id: int, *, rows: int) -> None:
        table = np.zeros((rows, WIDTH))
        table[:, INDEX["t"]] = 0.05 * np.arange(rows)
        table[:, INDEX["z"]] = 1.65
        table[:, INDEX["distance"]] = np.sin(np.arange(rows))
        files = RunFiles(self.settings.data, run_id, 1)
        files.append_rows(table)
        files.append_log(b"hello from the program\n")


@pytest.fixture
def site(settings: Settings, database: Database) -> Iterator[Site]:
    """A service without a worker."""
    app = create_app(settings)
    viewers, tokens = {}, {}
    with database.writing() as session:
        for name in ("ann", "ben", "root"):
            user = accounts.sign_up(session, name, None, is_admin=name == "root")
            viewers[name] = Viewer(user_id=user.id, name=name, is_admin=name == "root")
        for role, (name, scopes, days) in ROLES.items():
            user_id = viewers[name].user_id
            assert user_id is not None
            tokens[role] = accounts.new_token(session, user_id, role, scopes, days=days)
    made = Site(app, database, settings, viewers, tokens)
    yield made
    made.held.close()
