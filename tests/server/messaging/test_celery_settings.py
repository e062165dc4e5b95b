"""What Celery's settings are for, each by what it does or must be in proportion to."""

import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from celery.app.defaults import NAMESPACES, flatten
from celery.backends.base import DisabledBackend
from celery.concurrency import get_implementation
from celery.concurrency.prefork import TaskPool
from kombu.exceptions import ContentDisallowed
from kombu.serialization import dumps, loads
from redis import Redis

from seamark.server.messaging import broker
from seamark.server.settings import Settings
from tests.services.ports import free_port

KNOWN = {name for name, _ in flatten(NAMESPACES)}


@contextmanager
def _broker_that_hangs_up() -> Iterator[tuple[int, list[int]]]:
    """Yield the port of a server that closes every connection, and the list of connections."""
    connections: list[int] = []
    with socket.create_server(("127.0.0.1", 0)) as server:

        def serve() -> None:
            while True:
                try:
                    client, (_, port) = server.accept()
                except OSError:
                    return
                connections.append(port)
                client.close()

        thread = threading.Thread(target=serve, daemon=True)
        thread.start()
        yield server.getsockname()[1], connections
        server.shutdown(socket.SHUT_RDWR)
        thread.join()


def test_every_setting_is_one_that_celery_knows(settings: Settings) -> None:
    changed = {*broker._TICKETS, *broker._WORKERS, *broker._CONNECTIONS}

    assert changed <= KNOWN


def test_a_ticket_is_plain_json_that_names_no_run_and_leaves_no_result(settings: Settings) -> None:
    app = broker.celery_app(settings)
    with Redis.from_url(settings.broker_url) as redis:
        redis.flushall()

        assert broker.send_tickets(app)

        keys = {key.decode() for key in redis.keys()}
        [ticket] = redis.lrange(next(key for key in keys if key in broker.ticket_keys(app)), 0, -1)
    bindings = {"_kombu.binding.runs", "_kombu.binding_permanent.runs"}
    assert keys <= {*bindings, *broker.ticket_keys(app)}
    assert b'"content-type": "application/json"' in ticket
    assert b'"argsrepr": "()"' in ticket
    assert isinstance(app.backend, DisabledBackend)


def test_a_pickled_message_is_refused_unread(settings: Settings) -> None:
    accepted = broker.celery_app(settings).conf.accept_content
    content_type, encoding, pickled = dumps({"a": 1}, serializer="pickle")  # type: ignore[no-untyped-call]

    with pytest.raises(ContentDisallowed):
        loads(pickled, content_type, encoding, accept=accepted)  # type: ignore[no-untyped-call]


def test_a_broker_that_is_away_costs_a_web_thread_one_attempt(settings: Settings) -> None:
    with _broker_that_hangs_up() as (port, connections):
        away = settings.model_copy(update={"broker_url": f"redis://127.0.0.1:{port}/0"})

        assert not broker.send_tickets(broker.celery_app(away))

        assert 1 <= len(connections) <= 2  # the second is redis-py's, for a connection that broke


def test_a_refused_connection_is_no_error_of_a_page(settings: Settings) -> None:
    nowhere = settings.model_copy(update={"broker_url": f"redis://127.0.0.1:{free_port()}/0"})

    assert not broker.send_tickets(broker.celery_app(nowhere))


def test_a_ticket_outlasts_the_longest_run_before_it_is_delivered_again(settings: Settings) -> None:
    conf = broker.celery_app(settings).conf
    transport = conf.broker_transport_options

    assert transport["visibility_timeout"] > conf.task_time_limit > 3600
    assert transport["health_check_interval"] < transport["socket_timeout"]


@pytest.mark.parametrize("url", ["redis://127.0.0.1:6379/0", "unix:///run/broker.sock"])
def test_tcp_connections_are_kept_alive_and_unix_sockets_accept_the_options(
    settings: Settings, url: str
) -> None:
    conf = broker.celery_app(settings.model_copy(update={"broker_url": url})).conf

    assert conf.broker_transport_options.get("socket_keepalive", False) == url.startswith("redis")


def test_a_worker_takes_no_more_tickets_than_it_has_processes(settings: Settings) -> None:
    conf = broker.celery_app(settings).conf

    assert (conf.task_acks_late, conf.worker_prefetch_multiplier) == (True, 1)
    assert (conf.task_acks_on_failure_or_timeout, conf.task_reject_on_worker_lost) == (True, False)


def test_processes_can_be_killed_and_are_given_time_to_start(settings: Settings) -> None:
    conf = broker.celery_app(settings).conf

    assert get_implementation(conf.worker_pool) is TaskPool
    assert conf.worker_proc_alive_timeout >= 60
    assert conf.worker_max_tasks_per_child > 100
    assert conf.worker_max_memory_per_child is None


def test_a_worker_that_loses_its_broker_keeps_its_runs_and_waits(settings: Settings) -> None:
    conf = broker.celery_app(settings).conf

    assert not conf.worker_cancel_long_running_tasks_on_connection_loss
    assert conf.broker_connection_retry
    assert conf.broker_connection_retry_on_startup
    assert conf.broker_connection_max_retries is None
