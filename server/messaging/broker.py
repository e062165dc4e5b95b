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


def connect(settings: Settings) -> "Redis":
    """Return a Redis client; it connects at its first command."""
    url = redis_url(settings)
    options: dict[str, Any] = {"socket_timeout": 10, "health_check_interval": 25}
    if not url.startswith("unix:"):
        options["socket_keepalive"] = True  # on a Unix socket redis-py raises TypeError for it
    return Redis.from_url(url, **options)


def connect_async(settings: Settings) -> "asyncio.Redis":
    """Return a Redis client for an event loop, which may wait for messages for any time."""
    return asyncio.Redis.from_url(redis_url(settings), health_check_interval=25)


def celery_app(settings: Settings) -> Celery:
    """Return the Celery application. Its messages are tickets: "there is work", without a run."""
    url = redis_url(settings)
    app = Celery(
        "seamark", broker=url.replace("unix://", "redis+socket://", 1), set_as_current=False
    )
    transport: dict[str, Any] = {
        # Longer than any run; a ticket that is delivered twice does no harm.
        "visibility_timeout": 3 * TIME_LIMIT_S,
        "unacked_restore_interval": 30,
        "unacked_restore_throttle": 1,
        "health_check_interval": 25,
        "socket_timeout": 30,
        "socket_connect_timeout": 5,
        # By default a call retries for 6 s, while a web thread waits. Workers reconnect anyway.
        "max_retries": 0,
        "queue_order_strategy": "priority",
        "priority_steps": [0, 3, 6, 9],
    }
    if not url.startswith("unix:"):
        transport["socket_keepalive"] = True
    app.conf.update(
        task_ignore_result=True,
        task_serializer="json",
        accept_content=["json"],
        task_acks_late=True,
        task_acks_on_failure_or_timeout=True,
        task_reject_on_worker_lost=False,  # expired leases are requeued instead
        worker_prefetch_multiplier=1,
        task_time_limit=TIME_LIMIT_S,
        task_default_queue=QUEUE,
        task_default_priority=6,
        worker_cancel_long_running_tasks_on_connection_loss=False,
        worker_soft_shutdown_timeout=10,
        worker_enable_soft_shutdown_on_idle=False,
        # Rare: until its successor is ready, a process passes tickets on, for two seconds.
        worker_max_tasks_per_child=1000,
        worker_send_task_events=False,
        worker_hijack_root_logger=False,
        broker_connection_retry_on_startup=True,
        broker_connection_max_retries=None,
        broker_pool_limit=4,
        broker_transport_options=transport,
    )
    return app


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


def top_up(app: Celery, redis: "Redis", queued: int) -> int:
    """Send the tickets that `queued` runs lack and return their number."""
    sent = sum(int(redis.llen(key)) for key in ticket_keys(app))
    missing = max(queued - sent, 0)
    return missing if missing and send_tickets(app, missing) else 0


def ticket_keys(app: Celery) -> list[str]:
    """Return the keys of the Redis lists that hold tickets, one for each priority."""
    steps = app.conf.broker_transport_options["priority_steps"]
    return [QUEUE if step == 0 else f"{QUEUE}\x06\x16{step}" for step in steps]
