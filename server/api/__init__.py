"""The HTTP API under /api/v1: one file per resource."""

from __future__ import annotations

from flask import Flask

from seamark.server.api import openapi
from seamark.server.api.account import account, mail, profiles
from seamark.server.api.administration import administration, rejudgements
from seamark.server.api.classes import assignments, classes
from seamark.server.api.competitions import boards, competitions, teams
from seamark.server.api.data import (
    datasets,
    demo,
    events,
    files,
    formats,
    recognition,
    scene,
    series,
)
from seamark.server.api.leaderboards import benchmarks, leaderboards
from seamark.server.api.runs import (
    actions,
    checks,
    compare,
    mission_logs,
    publications,
    rosbridge,
    runs,
    sweeps,
    vehicles,
)
from seamark.server.api.service import environment, health, metrics

RESOURCES = (
    benchmarks.api,
    environment.api,
    runs.api,
    mission_logs.api,
    sweeps.api,
    checks.api,
    vehicles.api,
    actions.api,
    publications.api,
    events.api,
    files.api,
    formats.api,
    datasets.api,
    series.api,
    recognition.api,
    compare.api,
    scene.api,
    demo.api,
    leaderboards.api,
    profiles.api,
    account.api,
    mail.api,
    classes.api,
    assignments.api,
    competitions.api,
    boards.api,
    teams.api,
    administration.api,
    rejudgements.api,
    rosbridge.api,
)


def register(app: Flask) -> None:
    """Add the API, its documentation, and the endpoints for operators."""
    for resource in RESOURCES:
        app.register_blueprint(resource)
    app.register_blueprint(openapi.page)
    app.register_blueprint(health.page)
    app.register_blueprint(metrics.page)
    openapi.store(app, RESOURCES)
