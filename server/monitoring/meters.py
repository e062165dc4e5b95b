"""What the processes of a service count and time for monitoring, declared once.

Each process adds to its own copy; `seamark.server.messaging.shared_meters` adds the copies of all
processes of all machines together. Series that alerts watch exist from the start: `increase()` does
not see the first value of one that appears later.
"""

from prometheus_client import CollectorRegistry, Counter, Histogram, disable_created_metrics

disable_created_metrics()  # type: ignore[no-untyped-call] # no meaning across processes

REGISTRY = CollectorRegistry()
_SHORT = (0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 10.0)  # [s]
_LONG = (0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 60.0, 120.0, 300.0, 900.0, 3600.0)  # [s]

HTTP_REQUESTS = Counter(
    "seamark_http_requests_total",
    "Answered HTTP requests, by route template",
    ("method", "route", "status"),
    registry=REGISTRY,
)
HTTP_SECONDS = Histogram(
    "seamark_http_request_duration_seconds",
    "Time from the whole request to the head of the answer",
    ("route",),
    buckets=_SHORT,
    registry=REGISTRY,
)
RUNS_ENDED = Counter(
    "seamark_runs_ended_total",
    "Runs that ended, by state and, if they failed, by cause",
    ("kind", "state", "cause"),
    registry=REGISTRY,
)
for _kind in ("practice", "ranked"):
    RUNS_ENDED.labels(_kind, "failed", "platform_error")
RUN_WAITING = Histogram(
    "seamark_run_waiting_seconds",
    "Time from the submission of a run to its first start, by lane of the queue",
    ("lane",),
    buckets=_LONG,
    registry=REGISTRY,
)
RUN_PHASE = Histogram(
    "seamark_run_phase_seconds",
    "Duration of each phase of a run: starting (from the claim to its simulator process), "
    "preparing (compiling, starting the program), simulating, storing",
    ("phase",),
    buckets=_LONG,
    registry=REGISTRY,
)
ATTEMPTS_LOST = Counter(
    "seamark_attempts_lost_total",
    "Attempts at a run that ended without a result, by reason and by the state that the run got: "
    "queued means that it is repeated",
    ("reason", "state"),
    registry=REGISTRY,
)
for _reason in ("evaluation_broke", "storage_failed", "worker_lost"):
    for _state in ("queued", "failed"):
        ATTEMPTS_LOST.labels(_reason, _state)
LEASES_LOST = Counter(
    "seamark_leases_lost_total",
    "Leases that a living worker lost to another one while it evaluated the run",
    registry=REGISTRY,
)
BOX_START = Histogram(
    "seamark_box_start_seconds",
    "Time from asking for a box until the program in it was loaded",
    ("language",),
    buckets=_SHORT,
    registry=REGISTRY,
)
BOX_FAILURES = Counter(
    "seamark_box_failures_total",
    "Boxes that failed by themselves, not by their program",
    registry=REGISTRY,
)
CHECKS_ENDED = Counter(
    "seamark_checks_ended_total",
    "Checks of programs that ended: passed, failed, or broken by the platform",
    ("result",),
    registry=REGISTRY,
)
for _result in ("passed", "failed", "broken"):
    CHECKS_ENDED.labels(_result)
CHECK_SECONDS = Histogram(
    "seamark_check_duration_seconds",
    "Time that a worker took for a check",
    buckets=_SHORT,
    registry=REGISTRY,
)
MAINTENANCE_SECONDS = Histogram(
    "seamark_maintenance_duration_seconds",
    "Duration of the periodic tasks of the workers",
    ("task",),
    buckets=_LONG,
    registry=REGISTRY,
)
MAINTENANCE_FAILURES = Counter(
    "seamark_maintenance_failures_total",
    "Periodic tasks of the workers that failed",
    ("task",),
    registry=REGISTRY,
)
MAILS = Counter(
    "seamark_mails_total",
    "E-mails by outcome: sent, delayed (tried again), refused by the server, given up after a day, "
    "or dropped because nobody has confirmed the address",
    ("outcome",),
    registry=REGISTRY,
)
for _outcome in ("sent", "delayed", "refused", "given_up", "dropped"):
    MAILS.labels(_outcome)
RETENTION_RUNS = Counter(
    "seamark_retention_runs_total",
    "Runs whose data were deleted by a rule of retention: age or size",
    ("rule",),
    registry=REGISTRY,
)
