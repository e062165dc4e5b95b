"""For monitoring: liveness and readiness of the service."""

from flask import Blueprint, Response, jsonify
from redis.exceptions import RedisError
from sqlalchemy import text
from sqlalchemy.exc import SQLAlchemyError

from seamark.server import storage, workers
from seamark.server.web.services import services

page = Blueprint("health", __name__)


@page.get("/healthz")
def alive() -> Response:
    """Return "ok" if this process answers; other processes are not checked."""
    return Response("ok\n", content_type="text/plain; charset=utf-8")


@page.get("/readyz")
def ready() -> Response:
    """Return whether a run that is submitted now would be evaluated, and what is missing."""
    checks = {"database": _database(), "broker": _broker()}
    checks["storage"] = storage.refusal(services().settings) or "ok"
    checks["worker"] = _worker() if checks["database"] == "ok" else "unknown"
    good = all(value == "ok" for value in checks.values())
    answer = jsonify({"ready": good, "checks": checks})
    answer.status_code = 200 if good else 503
    if not good:
        answer.headers["Retry-After"] = "5"
    return answer


def _database() -> str:
    try:
        with services().database.reading() as database:
            database.execute(text("SELECT 1"))
    except SQLAlchemyError as error:
        return type(error).__name__
    return "ok"


def _broker() -> str:
    try:
        services().redis.ping()
    except RedisError as error:
        return type(error).__name__
    return "ok"


def _worker() -> str:
    with services().database.reading() as database:
        return "ok" if workers.alive_count(database) else "no worker is alive"
