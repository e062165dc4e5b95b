"""For whoever operates the service: is it alive, is it ready, how does it do."""

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
from sqlalchemy import func, select, text
from sqlalchemy.exc import SQLAlchemyError

from seamark.server import workers
from seamark.server.database.tables import Run
from seamark.server.runs.states import RunState
from seamark.server.web.services import Services, services
from seamark.server.workers import WorkerStatus

page = Blueprint("health", __name__)
_KEY = "seamark-metrics"


class Meters:
    """The counters of one web process and what is read from the database when somebody asks."""

    def __init__(self, held: Services) -> None:
        self.registry = CollectorRegistry()
        self.answers = Counter(
            "seamark_http_answers", "Answers", ("endpoint", "status"), registry=self.registry
        )
        self.seconds = Histogram(
            "seamark_http_seconds", "Time until an answer", ("endpoint",), registry=self.registry
        )
        self.registry.register(_Queue(held))


class _Queue(Collector):
    """Numbers that all processes share, so they come from the database and not from counters."""

    def __init__(self, held: Services) -> None:
        self._held = held

    def describe(self) -> Iterable[Metric]:
        """Return nothing: the names are known only when the numbers are."""
        return ()

    def collect(self) -> Iterable[Metric]:
        """Read the numbers."""
        runs = GaugeMetricFamily("seamark_runs", "Runs by state", labels=("state",))
        with self._held.database.reading() as database:
            counts = dict.fromkeys((state.value for state in RunState), 0)
            for state, number in database.execute(
                select(Run.state, func.count()).group_by(Run.state)
            ):
                counts[state] = number
            oldest = database.scalar(
                select(func.min(Run.queued_at)).where(Run.state == RunState.QUEUED)
            )
            listed = workers.listed(database)
        for state, count in counts.items():
            runs.add_metric((state,), count)
        waited = 0.0 if oldest is None else max(time.time() - oldest, 0.0)
        yield runs
        yield GaugeMetricFamily(
            "seamark_queue_oldest_seconds", "Waiting time of the oldest queued run", value=waited
        )
        alive = [worker for worker in listed if worker.alive]
        yield GaugeMetricFamily("seamark_workers_alive", "Workers alive", value=len(alive))
        yield _process_states(alive)
        yield GaugeMetricFamily(
            "seamark_streams_open", "Live streams", value=self._held.fanout.open_streams
        )


def _process_states(alive: Iterable[WorkerStatus]) -> GaugeMetricFamily:
    states = GaugeMetricFamily(
        "seamark_worker_process_up",
        "Whether a side process of a worker is running (1) or broken (0)",
        labels=("worker", "process"),
    )
    for worker in alive:
        for name, state in worker.processes.items():
            states.add_metric((worker.name, name), float(state == workers.RUNNING))
    return states


def start_watch() -> None:
    """Remember when the request came; called before each request."""
    g.came_at = time.perf_counter()


def count(answer: Response) -> Response:
    """Count an answer; called after each request."""
    meters: Meters = current_app.extensions[_KEY]
    endpoint = request.endpoint or "none"
    meters.answers.labels(endpoint, str(answer.status_code)).inc()
    if "came_at" in g:
        meters.seconds.labels(endpoint).observe(time.perf_counter() - g.came_at)
    return answer


@page.record_once
def _make_meters(state: object) -> None:
    app = state.app  # type: ignore[attr-defined]
    app.extensions[_KEY] = Meters(app.extensions["seamark"])
    app.before_request(start_watch)
    app.after_request(count)


@page.get("/healthz")
def alive() -> Response:
    """Say that this process answers; says nothing about the others."""
    return Response("ok\n", content_type="text/plain; charset=utf-8")


@page.get("/readyz")
def ready() -> Response:
    """Say whether a run that is ordered now would be carried out: database, broker, worker."""
    checks = {"database": _database(), "broker": _broker()}
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
    """Show the meters in Prometheus's text format."""
    meters: Meters = current_app.extensions[_KEY]
    return Response(generate_latest(meters.registry), content_type=CONTENT_TYPE_LATEST)
