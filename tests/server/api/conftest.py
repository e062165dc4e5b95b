"""The application with the cast; each role of the API's tests has a token."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from flask import Flask
from flask.testing import FlaskClient
from sqlalchemy import select
from werkzeug.test import TestResponse

from seamark.server.accounts import accounts
from seamark.server.app import create_app
from seamark.server.database.tables import Run
from seamark.server.programs import check_queue
from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.record.states import RunState
from seamark.server.web.services import Services
from seamark.sim.recording.telemetry import INDEX, WIDTH
from tests.cast import Backend

ROLES = {  # role -> account, scopes, days
    "other": ("ben", ("read", "submit"), 1.0),
    "owner": ("ann", ("read", "submit"), 1.0),
    "admin": ("root", ("read", "submit", "admin"), 1.0),
    "reader": ("ann", ("read",), 1.0),
    "submitter": ("ann", ("submit",), 1.0),
    "expired": ("ann", ("read", "submit"), -1.0),
}


@dataclass
class Site(Backend):
    """The application on the database of the cast."""

    app: Flask
    headers: dict[str, dict[str, str]]  # role -> headers of a request

    @property
    def services(self) -> Services:
        services: Services = self.app.extensions["seamark"]
        return services

    def client(self) -> FlaskClient:
        return self.app.test_client()

    def call(self, role: str, method: str, path: str, **options: Any) -> TestResponse:
        headers = self.headers[role] | options.pop("headers", {})
        return self.client().open(path, method=method, headers=headers, **options)

    def clear_queue(self) -> None:
        """Cancel the queued runs, so that the next run to be claimed is the next one queued."""
        with self.database.reading() as session:
            queued = list(session.scalars(select(Run.id).where(Run.state == RunState.QUEUED)))
        for run_id in queued:
            self.cancel(run_id)

    def queue_check(self, who: str = "ann") -> int:
        program = self.store_program()
        with self.database.writing() as session:
            return check_queue.enqueue(session, self.user_id(who), "currents-v1", {}, program)

    def recorded(self, **changes: Any) -> int:
        """Return a run of an uploaded program that succeeded, with 2 s of telemetry and a log."""
        uploaded: dict[str, Any] = {"controller": "upload", "program": self.store_program()}
        run_id = self.succeeded(**uploaded | changes)
        self.record(run_id, rows=40)
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
def site(backend: Backend) -> Iterator[Site]:
    """A service without a worker."""
    app = create_app(backend.settings)
    headers: dict[str, dict[str, str]] = {"guest": {}}
    with backend.database.writing() as session:
        for role, (name, scopes, days) in ROLES.items():
            token = accounts.new_token(session, backend.user_id(name), role, scopes, days=days)
            headers[role] = {"Authorization": f"Bearer {token}"}
    site = Site(**vars(backend), app=app, headers=headers)
    yield site
    site.services.close()
