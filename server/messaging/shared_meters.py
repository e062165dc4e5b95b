"""The meters of all processes, added together in the broker.

A service has web processes behind one address and workers without any, so no process could be
asked for all: each adds what it has counted since the last time, and any web process answers for
all. When the broker loses its data they start from zero, which Prometheus expects of counters.
"""

import json
import re
import secrets
import threading

from prometheus_client.metrics_core import Metric
from redis import Redis
from redis.exceptions import RedisError

from seamark.server.monitoring.meters import REGISTRY

COUNTED = "seamark.meters"  # a hash: name and labels as JSON -> sum of all processes
REPORTED = "seamark.meters.web"  # a hash: web process -> when it reported [s], its open streams
FRESH_S = 30.0  # a web process that has not reported for longer has ended
_SUFFIX = re.compile("_(total|bucket|count|sum)$")  # of the samples of a metric

Labels = tuple[tuple[str, str], ...]
Key = tuple[str, Labels]  # name of a sample, its labels


class SharedMeters:
    """Adds what this process counts, from now on, to what all count."""

    def __init__(self, redis: "Redis") -> None:
        self._redis = redis
        self._added = _counted_here()
        self._process = secrets.token_hex(8)
        self._listed = False
        self._lock = threading.Lock()

    def add(self) -> bool:
        """Add what was counted since the last time; False, and nothing, if the broker is away."""
        with self._lock:
            now = _counted_here()
            changes = {key: value - self._added.get(key, 0.0) for key, value in now.items()}
            try:
                with self._redis.pipeline() as pipeline:  # all or nothing
                    for key, change in changes.items():
                        if change or key not in self._added:  # a new one is there, at zero
                            pipeline.hincrbyfloat(COUNTED, json.dumps(key), change)
                    pipeline.execute()
            except RedisError:
                return False
            self._added = now
            return True

    def report(self, open_streams: int) -> None:
        """Say that this web process is there. Raises RedisError."""
        entry = json.dumps([_now_s(self._redis), open_streams])
        self._listed = True
        self._redis.hset(REPORTED, self._process, entry)

    def leave(self) -> None:
        """Take this web process off the list if it is there. Raises RedisError."""
        if self._listed:
            self._redis.hdel(REPORTED, self._process)


def collected(redis: "Redis") -> list[Metric]:
    """Return the meters of all processes. Raises RedisError."""
    stored: dict[bytes, bytes] = redis.hgetall(COUNTED)  # type: ignore[assignment]
    values = dict.fromkeys(_counted_here(), 0.0)  # what nobody has counted yet
    for field, total in stored.items():
        name, labels = json.loads(field)
        values[name, tuple((label, text) for label, text in labels)] = float(total)
    metrics = {
        declared.name: Metric(declared.name, declared.documentation, declared.type)
        for declared in REGISTRY.collect()
    }
    for (name, labels), value in sorted(values.items(), key=_order):
        metric = metrics.get(_SUFFIX.sub("", name))
        if metric is not None:  # else counted by a process of another version
            metric.add_sample(name, dict(labels), value)
    return list(metrics.values())


def web_processes(redis: "Redis") -> list[int]:
    """Return how many streams each web process has open. Raises RedisError."""
    stored: dict[bytes, bytes] = redis.hgetall(REPORTED)  # type: ignore[assignment]
    now_s, open_streams, gone = _now_s(redis), [], []
    for process, entry in stored.items():
        reported_s, streams = json.loads(entry)
        if now_s - reported_s < FRESH_S:
            open_streams.append(int(streams))
        else:
            gone.append(process)
    if gone:
        redis.hdel(REPORTED, *gone)
    return open_streams


def _counted_here() -> dict[Key, float]:
    samples = (sample for metric in REGISTRY.collect() for sample in metric.samples)
    return {(one.name, tuple(sorted(one.labels.items()))): one.value for one in samples}


def _order(item: tuple[Key, float]) -> tuple[Labels, str, float]:
    """Keep the series of a histogram together, with its limits ascending."""
    (name, labels), _ = item
    others = tuple((label, text) for label, text in labels if label != "le")
    return others, name, float(dict(labels).get("le", 0.0))


def _now_s(redis: "Redis") -> float:
    """Return the time of the broker: the clocks of the machines may differ."""
    seconds, microseconds = redis.time()
    return float(seconds) + float(microseconds) / 1e6
