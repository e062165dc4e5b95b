"""For monitoring: liveness, readiness and metrics of the service."""

from __future__ import annotations

import time
from collections.abc import Iterable

from flask import Blueprint, Response, current_app, g, jsonify, request
from prometheus_client import (
    CONTENT_TYPE_LATEST,
    CollectorRegistry,
    Counter,
    Histogram,
    generate_latest,
)
from prometheus_client.core import GaugeMetricFamily
from prometheus_client.metrics_core import Metric
from prometheus_client.registry import Collector
from redis.exceptions import RedisError
from sqlalchemy import text
from sqlalchemy.exc import SQLAlchemyError

from seamark.server import storage, workers
from seamark.server.runs import totals
from seamark.server.web.services import Services, services
from seamark.server.workers import WorkerStatus

page = Blueprint("health", __name__)
_KEY = "seamark-metrics"


class Meters:
    """The counters of one web process, and gauges that are read from the database."""

    def __init__(self, app_services: Services) -> None:
        self.registry = CollectorRegistry()
        self.answers = Counter(
            "seamark_http_answers", "Answers", ("endpoint", "status"), registry=self.registry
        )
        self.seconds = Histogram(
            "seamark_http_seconds", "Time until an answer", ("endpoint",), registry=self.registry
        )
        self.registry.register(_Queue(app_services))


class _Queue(Collector):
    """Gauges that all processes share: read from the database at each scrape."""

    def __init__(self, app_services: Services) -> None:
        self._held = app_services

    def describe(self) -> Iterable[Metric]:
        """Return nothing, so that registering does not read the database."""
        return ()

    def collect(self) -> Iterable[Metric]:
        """Read the gauges."""
        runs = GaugeMetricFamily("seamark_runs", "Runs by state", labels=("state",))
        with self._held.database.reading() as database:
            counts, oldest = totals.counts(database), totals.oldest_queued_at(database)
            listed = workers.listed(database)
        for state, count in counts.items():
            runs.add_metric((state.value,), count)
        waited = 0.0 if oldest is None else max(time.time() - oldest, 0.0)
        settings = self._held.settings
        yield GaugeMetricFamily(
            "seamark_storage_free_bytes",
            "Free bytes on the disk of the data folder; 0 if the folder is away",
            value=0 if storage.is_away(settings.data) else storage.free_bytes(settings.data),
        )
        yield GaugeMetricFamily(
            "seamark_storage_up",
            "Whether new runs can be stored (1), or the disk is too full or away (0)",
            value=float(storage.refusal(settings) is None),
        )
        yield runs
        yield GaugeMetricFamily(
            "seamark_queue_oldest_seconds", "Waiting time of the oldest queued run", value=waited
        )
        alive = [worker for worker in listed if worker.alive]
        yield GaugeMetricFamily("seamark_workers_alive", "Workers alive", value=len(alive))
        yield _process_states(alive)
        yield GaugeMetricFamily(
            "seamark_streams_open", "Live streams", value=self._held.streams.open_streams
        )


def _process_states(alive: Iterable[WorkerStatus]) -> GaugeMetricFamily:
    states = GaugeMetricFamily(
        "seamark_worker_process_up",
        "Whether a side process of a worker is running (1) or broken (0)",
        labels=("worker", "process"),
    )
    for worker in alive:
        for name in worker.processes:
            up = float(name not in worker.broken_processes)
            states.add_metric((worker.name, name), up)
    return states


def start_timer() -> None:
    """Record when the request arrived; called before each request."""
    g.started_at = time.perf_counter()


def count(answer: Response) -> Response:
    """Count a response; called after each request."""
    meters: Meters = current_app.extensions[_KEY]
    endpoint = request.endpoint or "none"
    meters.answers.labels(endpoint, str(answer.status_code)).inc()
    if "started_at" in g:
        meters.seconds.labels(endpoint).observe(time.perf_counter() - g.started_at)
    return answer


@page.record_once
def _make_meters(state: object) -> None:
    app = state.app  # type: ignore[attr-defined]
    app.extensions[_KEY] = Meters(app.extensions["seamark"])
    app.before_request(start_timer)
    app.after_request(count)


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


@page.get("/metrics")
def metrics() -> Response:
    """Return the metrics in the text format of Prometheus."""
    meters: Meters = current_app.extensions[_KEY]
    return Response(generate_latest(meters.registry), content_type=CONTENT_TYPE_LATEST)
