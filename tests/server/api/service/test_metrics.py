"""What Prometheus reads: complete over all processes, and nothing for strangers."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from prometheus_client.parser import text_string_to_metric_families
from redis import Redis

from seamark.server.app import create_app
from seamark.server.messaging.shared_meters import SharedMeters
from seamark.server.monitoring import meters
from seamark.server.runs.queue import lost_attempts, queue
from seamark.server.runs.queue.lost_attempts import AttemptEnd
from tests.cast import Backend
from tests.server.api.conftest import Site

TOKEN = "a-token-of-prometheus"
HOSTING = Path(__file__).parents[4] / "docs" / "hosting.md"
Values = dict[tuple[str, frozenset[tuple[str, str]]], float]


def values(text: str) -> Values:
    """Parse the metrics as Prometheus does: each series with its value."""
    families = text_string_to_metric_families(text)
    return {
        (sample.name, frozenset(sample.labels.items())): sample.value
        for family in families
        for sample in family.samples
    }


def value(found: Values, name: str, **labels: str) -> float:
    return found.get((name, frozenset(labels.items())), 0.0)


def scrape(site: Site) -> Values:
    return values(site.client().get("/metrics").text)


@contextmanager
def service(backend: Backend, **changes: object) -> Iterator[Site]:
    app = create_app(backend.settings.model_copy(update=changes))
    site = Site(**vars(backend), app=app, headers={})
    yield site
    site.services.close()


def test_the_queue_is_told_by_lane(backend: Backend) -> None:
    with service(backend) as site:
        backend.queue()
        backend.queue("ben")

        found = scrape(site)

    assert value(found, "seamark_queue_runs", lane="account") == 2
    assert value(found, "seamark_queue_runs", lane="guest") == 0
    assert value(found, "seamark_queue_oldest_seconds", lane="account") > 0


def test_a_run_is_counted_once_when_it_ends_and_its_wait_when_it_starts(backend: Backend) -> None:
    with service(backend) as site:
        backend.succeeded()
        backend.failed({})

        found = scrape(site)

    assert value(found, "seamark_run_waiting_seconds_count", lane="account") == 2
    ended = "seamark_runs_ended_total"
    assert value(found, ended, kind="practice", state="succeeded", cause="") == 1
    assert value(found, ended, kind="practice", state="failed", cause="user_error") == 1


@pytest.mark.slow
def test_a_transaction_that_is_rolled_back_counts_nothing(site: Site) -> None:
    site.queue()

    def claim_in_vain() -> None:
        with site.database.writing() as session:
            claimed = queue.try_claim(session, "w/0", languages=(), settings=site.settings)
            assert claimed is not None
            raise ConnectionError

    with pytest.raises(ConnectionError):
        claim_in_vain()
    assert value(scrape(site), "seamark_run_waiting_seconds_count", lane="account") == 0


def test_a_lost_worker_is_counted_with_what_became_of_its_run(site: Site) -> None:
    site.queue()
    with site.database.writing() as session:
        claim = queue.try_claim(session, "w/0", languages=(), settings=site.settings)
        assert claim is not None
        lost_attempts.release(session, claim, AttemptEnd.WORKER_LOST, settings=site.settings)

    found = scrape(site)

    assert value(found, "seamark_attempts_lost_total", reason="worker_lost", state="queued") == 1


def test_any_web_process_tells_what_all_processes_have_counted(site: Site) -> None:
    with Redis.from_url(site.settings.broker_url) as redis:
        elsewhere = SharedMeters(redis)
        site.client().get("/status")
        site.client().get("/status")
        elsewhere.add()  # as a process that has counted these two

        found = scrape(site)

    requests = value(
        found, "seamark_http_requests_total", method="GET", route="/status", status="200"
    )
    assert requests == 4  # two of each


def test_a_process_adds_only_what_is_new(redis_url: str) -> None:
    with Redis.from_url(redis_url) as redis:
        shared = SharedMeters(redis)
        meters.LEASES_LOST.inc()
        shared.add()
        shared.add()
        meters.LEASES_LOST.inc(2)
        shared.add()

        assert redis.hget("seamark.meters", '["seamark_leases_lost_total", []]') == b"3"


def test_without_the_broker_the_metrics_say_so(backend: Backend, tmp_path: Path) -> None:
    with service(backend, broker_url=f"unix://{tmp_path}/none.sock") as site:
        found = scrape(site)

    assert value(found, "seamark_broker_up") == 0
    assert value(found, "seamark_database_up") == 1


@pytest.mark.parametrize(
    ("changes", "headers", "address", "status"),
    [
        ({}, {}, "127.0.0.1", 200),
        ({}, {}, "::1", 200),
        ({}, {}, "192.0.2.1", 404),
        ({}, {"X-Forwarded-For": "192.0.2.1"}, "127.0.0.1", 404),  # a proxy that is not declared
        ({"proxies": 1}, {"X-Forwarded-For": "192.0.2.1"}, "127.0.0.1", 404),
        ({"metrics_token": TOKEN}, {}, "127.0.0.1", 401),
        ({"metrics_token": TOKEN}, {"Authorization": "Bearer wrong"}, "127.0.0.1", 401),
        ({"metrics_token": TOKEN}, {"Authorization": "Bearer \xe4"}, "127.0.0.1", 401),
        ({"metrics_token": TOKEN}, {"Authorization": f"Bearer {TOKEN}"}, "192.0.2.1", 200),
    ],
)
def test_strangers_read_no_metrics(
    backend: Backend,
    changes: dict[str, object],
    headers: dict[str, str],
    address: str,
    status: int,
) -> None:
    with service(backend, **changes) as site:
        environ = {"REMOTE_ADDR": address}
        answer = site.client().get("/metrics", headers=headers, environ_base=environ)

    assert answer.status_code == status


def test_the_documentation_names_each_metric_and_no_other(site: Site) -> None:
    text = site.client().get("/metrics").text
    exported = set(re.findall(r"^# TYPE (seamark_\w+) ", text, re.MULTILINE))

    documented = set(re.findall(r"^\| `(seamark_\w+)` \|", HOSTING.read_text(), re.MULTILINE))

    assert documented == exported
