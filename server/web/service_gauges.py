"""What the service is now, for monitoring: read from database, broker and disk at each scrape.

Every query reads an index with as many rows as there are live runs, owners who wait or workers, not
as many as there are runs.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterable
from importlib.metadata import version

from prometheus_client.core import GaugeMetricFamily, InfoMetricFamily
from prometheus_client.metrics_core import Metric
from redis.exceptions import RedisError
from sqlalchemy import select
from sqlalchemy.exc import SQLAlchemyError
from sqlalchemy.orm import Session

from seamark.server.messaging import shared_meters, workers
from seamark.server.messaging.workers import WorkerStatus
from seamark.server.programs import check_queue
from seamark.server.runs.record import totals, turns
from seamark.server.storage import storage
from seamark.server.web.services import Services

Gauge = GaugeMetricFamily
_STATES = ("ready", "preparing", "drained", "outdated", "lost")  # of workers


def of_all_processes(held: Services) -> Iterable[Metric]:
    """Return the meters of all processes and the state of the service, for Prometheus."""
    yield InfoMetricFamily("seamark_build", "Version", value={"version": version("seamark")})
    yield from _disk(held)
    yield from _broker(held)
    yield from _database(held)


def _disk(held: Services) -> Iterable[Metric]:
    settings = held.settings
    away = storage.is_away(settings)
    yield Gauge(
        "seamark_storage_free_bytes",
        "Free bytes on the disk of the data folder; 0 if the folder is away",
        value=0 if away else storage.free_bytes(settings.data),
    )
    yield Gauge(
        "seamark_storage_free_min_bytes",
        "Free bytes below which no new runs are accepted",
        value=settings.free_min_bytes,
    )
    yield Gauge(
        "seamark_storage_up",
        "Whether new runs can be stored (1), or the disk is too full or away (0)",
        value=float(storage.refusal(settings) is None),
    )


def _broker(held: Services) -> Iterable[Metric]:
    redis = held.redis
    asked_at = time.perf_counter()
    try:
        redis.ping()
        ping_s = time.perf_counter() - asked_at
        memory = redis.info("memory")
        streams = shared_meters.web_processes(redis)
        counted = shared_meters.collected(redis)
    except RedisError:
        yield _up("broker", value=0)
        return
    yield _up("broker", value=1)
    yield Gauge("seamark_broker_ping_seconds", "Round trip to the broker", value=ping_s)
    yield Gauge(
        "seamark_broker_memory_bytes", "Memory used by the broker", value=memory["used_memory"]
    )
    yield Gauge(
        "seamark_broker_memory_max_bytes",
        "Memory that the broker may use; 0: no limit",
        value=memory["maxmemory"],
    )
    yield Gauge("seamark_web_processes", "Web processes that reported just now", value=len(streams))
    yield Gauge("seamark_streams_open", "Live streams of all web processes", value=sum(streams))
    yield from counted


def _database(held: Services) -> Iterable[Metric]:
    try:
        with held.database.reading() as session:
            asked_at = time.perf_counter()
            session.scalar(select(1))
            ping_s = time.perf_counter() - asked_at
            gauges = [*_runs(session), *_checks(session), *_workers(session)]
    except SQLAlchemyError:
        yield _up("database", value=0)
        return
    yield _up("database", value=1)
    yield Gauge("seamark_database_ping_seconds", "Round trip to the database", value=ping_s)
    yield from gauges


def _up(part: str, *, value: int) -> Metric:
    help_text = f"Whether this web process reaches the {part} (1) or not (0)"
    return Gauge(f"seamark_{part}_up", help_text, value=value)


def _runs(session: Session) -> Iterable[Metric]:
    runs = Gauge(
        "seamark_runs", "Runs by state; of ended ones all there ever were", labels=["state"]
    )
    for state, count in totals.counts(session).items():
        runs.add_metric([state.value], count)
    yield runs
    queued = Gauge("seamark_queue_runs", "Queued runs, by lane of the queue", labels=["lane"])
    oldest = Gauge(
        "seamark_queue_oldest_seconds",
        "How long the oldest of the queued runs of each lane has waited",
        labels=["lane"],
    )
    for load in turns.loads(session):
        queued.add_metric([load.name], load.queued)
        waited = 0.0 if load.oldest_at is None else max(time.time() - load.oldest_at, 0.0)
        oldest.add_metric([load.name], waited)
    yield from (queued, oldest)


def _checks(session: Session) -> Iterable[Metric]:
    checks = Gauge("seamark_checks", "Checks of programs by state", labels=["state"])
    for state, count in check_queue.counts(session).items():
        checks.add_metric([state.value], count)
    yield checks


def _workers(session: Session) -> Iterable[Metric]:
    listed = workers.listed(session)
    states = Counter(_state(worker) for worker in listed)
    counts = Gauge("seamark_workers", "Workers by state", labels=["state"])
    for state in _STATES:
        counts.add_metric([state], states[state])
    yield counts
    alive = [worker for worker in listed if worker.alive]
    slots = sum(worker.slots for worker in listed if worker.claims)
    yield Gauge("seamark_places", "Runs that the living workers can run together", value=slots)
    yield from _each_worker(listed)
    yield _side_processes(alive)


def _each_worker(listed: Iterable[WorkerStatus]) -> Iterable[Metric]:
    info = InfoMetricFamily("seamark_worker", "What each worker is", labels=["worker"])
    heartbeat = Gauge(
        "seamark_worker_heartbeat_age_seconds",
        "Time since the last heartbeat of each worker",
        labels=["worker"],
    )
    slots = Gauge(
        "seamark_worker_places", "Runs that each worker can run together", labels=["worker"]
    )
    for worker in listed:
        info.add_metric([worker.name], {"version": worker.version, "level": worker.level})
        heartbeat.add_metric([worker.name], worker.silent_s)
        slots.add_metric([worker.name], worker.slots)
    yield from (info, heartbeat, slots)


def _state(worker: WorkerStatus) -> str:
    if not worker.alive:
        return "lost"
    if worker.drained_at is not None:
        return "drained"
    if worker.outdated:
        return "outdated"
    return "preparing" if worker.preparing else "ready"


def _side_processes(alive: Iterable[WorkerStatus]) -> Metric:
    states = Gauge(
        "seamark_worker_process_up",
        "Whether a side process of a worker is running (1) or broken (0)",
        labels=["worker", "process"],
    )
    for worker in alive:
        for name in worker.processes:
            up = float(name not in worker.broken_processes)
            states.add_metric([worker.name, name], up)
    return states
