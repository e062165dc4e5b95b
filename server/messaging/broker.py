"""The broker: Celery's configuration, shared by web and worker, and the Redis client."""

from typing import Any

import structlog
from celery import Celery
from kombu.exceptions import OperationalError
from redis import Redis, asyncio
from redis.exceptions import RedisError

from seamark.server.settings import Settings

QUEUE = "runs"
# A fixed name: tickets that wait in the broker survive a move of the module.
WORK = "seamark.work"
TIME_LIMIT_S = (
    4 * 3600
)  # a backstop: stalls, the limits of the sandbox and cancelling end runs long before
_log = structlog.get_logger()


class BrokerMissing(Exception):
    """No broker is configured. The text says what to set."""


def redis_url(settings: Settings) -> str:
    """Return the URL for redis-py: redis://..., rediss://... or unix:///path."""
    if not settings.broker_url:
        raise BrokerMissing(
            "SEAMARK_BROKER_URL is not set: give a Redis URL, or use `seamark up`, "
            "which starts a broker of its own"
        )
    return settings.broker_url.replace("redis+socket://", "unix://", 1)


def connect(settings: Settings, *, timeout_s: float = 10.0) -> "Redis":
    """Return a Redis client; it connects at its first command.

    Parameters
    ----------
    timeout_s
        How long a command waits for a broker that does not answer.
    """
    url = redis_url(settings)
    options: dict[str, Any] = {"socket_timeout": timeout_s, "health_check_interval": 25}
    if not url.startswith("unix:"):
        options["socket_keepalive"] = True  # on a Unix socket redis-py raises TypeError for it
    return Redis.from_url(url, **options)


def connect_async(settings: Settings) -> "asyncio.Redis":
    """Return a Redis client for an event loop, which may wait for messages for any time."""
    return asyncio.Redis.from_url(redis_url(settings), health_check_interval=25)


def celery_app(settings: Settings) -> Celery:
    """Return the Celery application. Its messages are tickets: "there is work", without a run.

    What decides between runs, owns them and repeats them is the database; so a setting below may
    lose or double a ticket, but never a run.
    """
    url = redis_url(settings)
    app = Celery(
        "seamark", broker=url.replace("unix://", "redis+socket://", 1), set_as_current=False
    )
    app.conf.update(
        **_TICKETS, **_WORKERS, **_CONNECTIONS, broker_transport_options=_transport(url)
    )
    return app


_TICKETS: dict[str, Any] = {
    "task_default_queue": QUEUE,
    "task_default_priority": 6,  # room for tickets that are more and less urgent
    # Nothing but plain data is ever unpickled, whoever writes into the broker.
    "task_serializer": "json",
    "accept_content": ["json"],
    # Results and states of runs are in the database; Redis would keep a second truth for a day.
    "result_backend": None,
    "task_ignore_result": True,
    "task_track_started": False,
    # A ticket is taken out when its run has ended, so a worker has as many as it has processes ...
    "task_acks_late": True,
    "worker_prefetch_multiplier": 1,
    # ... and none comes back with the same failure, or with the worker that died at it: expired
    # leases are requeued instead, and their runs count the attempts.
    "task_acks_on_failure_or_timeout": True,
    "task_reject_on_worker_lost": False,
    # A backstop that kills the process; the driver of a run stops it far earlier and says why.
    "task_time_limit": TIME_LIMIT_S,
    "task_soft_time_limit": None,
    # Monitoring reads the database. Events would be published for every ticket, for nobody.
    "task_send_sent_event": False,
    "worker_send_task_events": False,
}
_WORKERS: dict[str, Any] = {
    "worker_pool": "prefork",  # the only pool whose processes can be killed, by time limits too
    # By default a process that has not started after 4 s is killed; it connects to the database
    # and starts a simulator, and on a busy machine it would be killed again and again.
    "worker_proc_alive_timeout": 120.0,
    # A guard against leaks. Rare: until its successor is ready, a process passes tickets on, for
    # two seconds. Memory is not limited here but by the cgroup: Celery would look at the peak.
    "worker_max_tasks_per_child": 1000,
    "worker_max_memory_per_child": None,
    # A run goes on while the broker is away: its lease is in the database.
    "worker_cancel_long_running_tasks_on_connection_loss": False,
    # At SIGTERM runs return to the queue at once (seamark.worker.service.tasks); this is the limit.
    "worker_soft_shutdown_timeout": 10,
    "worker_enable_soft_shutdown_on_idle": False,
    "worker_enable_remote_control": True,  # for `seamark worker --ping`
    "worker_hijack_root_logger": False,  # structlog writes the log
}
_CONNECTIONS: dict[str, Any] = {
    # A worker waits for its broker, at its start and later, for as long as it takes.
    "broker_connection_retry_on_startup": True,
    "broker_connection_retry": True,
    "broker_connection_max_retries": None,
    "broker_pool_limit": 4,  # a web process sends one ticket per submitted run
}


def _transport(url: str) -> dict[str, Any]:
    """Return the options of the Redis transport."""
    options: dict[str, Any] = {
        # A ticket that is not taken out counts as lost after this time and is delivered again: it
        # must be longer than any run. If it happens nevertheless it does no harm.
        "visibility_timeout": 3 * TIME_LIMIT_S,
        "unacked_restore_interval": 30,
        "unacked_restore_throttle": 1,
        # A connection that died without a word (a firewall, a machine that lost power) is noticed.
        "health_check_interval": 25,
        "socket_timeout": 30,
        "socket_connect_timeout": 5,
        # By default a call retries for 6 s, while a web thread waits. Workers reconnect anyway.
        "max_retries": 0,
        "queue_order_strategy": "priority",
        "priority_steps": [0, 3, 6, 9],
    }
    if not url.startswith("unix:"):
        options["socket_keepalive"] = True  # on a Unix socket redis-py raises TypeError for it
    return options


def send_tickets(app: Celery, count: int = 1) -> bool:
    """Send tickets, after the commit; False if the broker is away.

    The maintenance of the workers sends missing tickets later (`top_up`).
    """
    try:
        for _ in range(count):
            app.send_task(WORK, ignore_result=True, retry=False)
    except (OperationalError, RedisError) as error:
        _log.warning("tickets_not_sent", error=str(error))
        return False
    return True


def top_up(app: Celery, redis: "Redis", needed: int) -> int:
    """Send what is missing of the tickets that are needed and return how many these are."""
    sent = sum(int(redis.llen(key)) for key in ticket_keys(app))
    missing = max(needed - sent, 0)
    return missing if missing and send_tickets(app, missing) else 0


def ticket_keys(app: Celery) -> list[str]:
    """Return the keys of the Redis lists that hold tickets, one for each priority."""
    steps = app.conf.broker_transport_options["priority_steps"]
    return [QUEUE if step == 0 else f"{QUEUE}\x06\x16{step}" for step in steps]
