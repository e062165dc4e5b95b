"""For monitoring: liveness and readiness of the service."""

from flask import Blueprint, Response, jsonify

from seamark.server.web import readiness
from seamark.server.web.services import services

page = Blueprint("health", __name__)


@page.get("/healthz")
def alive() -> Response:
    """Return "ok" if this process answers; other processes are not checked."""
    return Response("ok\n", content_type="text/plain; charset=utf-8")


@page.get("/readyz")
def ready() -> Response:
    """Return whether a run that is submitted now would be evaluated, and what is missing."""
    checks = services().readiness.checks()
    good = all(value == readiness.OK for value in checks.values())
    answer = jsonify({"ready": good, "checks": checks})
    answer.status_code = 200 if good else 503
    if not good:
        answer.headers["Retry-After"] = "5"
    return answer
