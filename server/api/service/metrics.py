"""Metrics of the whole service for Prometheus, whichever web process answers."""

from __future__ import annotations

import hmac
import ipaddress
import threading
import time
from collections.abc import Iterable

from flask import Blueprint, Response, current_app, g, request
from prometheus_client import CONTENT_TYPE_LATEST, CollectorRegistry, generate_latest
from prometheus_client.metrics_core import Metric
from prometheus_client.registry import Collector
from werkzeug.exceptions import NotFound

from seamark.server.monitoring import meters
from seamark.server.web import service_gauges
from seamark.server.web.services import Services, services

page = Blueprint("metrics", __name__)
KEPT_S = 1.0  # of an answer: any number of scrapes costs no more than one a second
_KEY = "seamark-metrics"


class _Service(Collector):
    """The state of the service, and what all of its processes have counted."""

    def __init__(self, held: Services) -> None:
        self._held = held

    def describe(self) -> Iterable[Metric]:
        """Return nothing, so that registering does not read the database."""
        return ()

    def collect(self) -> Iterable[Metric]:
        """Read everything."""
        return service_gauges.of_all_processes(self._held)


class Exposition:
    """The metrics as text, made anew at most once in `KEPT_S`."""

    def __init__(self, held: Services) -> None:
        self._held = held
        self._registry = CollectorRegistry()
        self._registry.register(_Service(held))
        self._lock = threading.Lock()
        self._made_at = -KEPT_S
        self._text = b""

    def text(self) -> bytes:
        """Return the text; callers at the same time wait for the first of them."""
        with self._lock:
            if time.monotonic() - self._made_at >= KEPT_S:
                self._held.share_meters()
                self._text = generate_latest(self._registry)
                self._made_at = time.monotonic()
            return self._text


@page.record_once
def _register(state: object) -> None:
    app = state.app  # type: ignore[attr-defined]
    app.extensions[_KEY] = Exposition(app.extensions["seamark"])
    app.before_request(start_timer)
    app.after_request(count)


def start_timer() -> None:
    """Record when the request arrived; called before each request."""
    g.started_at = time.perf_counter()


def count(answer: Response) -> Response:
    """Count a response; called after each request."""
    route = request.url_rule.rule if request.url_rule else "none"
    method = request.method if request.url_rule else "any"
    meters.HTTP_REQUESTS.labels(method, route, str(answer.status_code)).inc()
    if "started_at" in g:
        meters.HTTP_SECONDS.labels(route).observe(time.perf_counter() - g.started_at)
    return answer


@page.get("/metrics")
def metrics() -> Response:
    """Return the metrics in the text format of Prometheus, to those who may read them."""
    settings = services().settings
    if settings.metrics_token and not _has_token(settings.metrics_token):
        refusal = Response("The metrics need a token.\n", 401, content_type="text/plain")
        refusal.headers["WWW-Authenticate"] = "Bearer"
        return refusal
    if not settings.metrics_token and not _is_local():
        raise NotFound
    exposition: Exposition = current_app.extensions[_KEY]
    return Response(exposition.text(), content_type=CONTENT_TYPE_LATEST)


def _has_token(token: str) -> bool:
    given = request.authorization
    if given is None or given.type != "bearer" or given.token is None:
        return False
    return hmac.compare_digest(given.token.encode(), token.encode())


def _is_local() -> bool:
    """Return whether the request comes from this machine, and from no proxy on it."""
    forwarded = {"Forwarded", "X-Forwarded-For", "X-Real-IP", "Via"} & set(request.headers.keys())
    if forwarded and not services().settings.proxies:
        return False
    try:
        return ipaddress.ip_address(request.remote_addr or "").is_loopback
    except ValueError:
        return False
