"""What an operator sees of a run on a real service: logs, followed by one id, and metrics."""

import json
import re
import time
from contextlib import closing
from dataclasses import dataclass
from typing import Any

import httpx
import pytest
from prometheus_client.parser import text_string_to_metric_families

from seamark.client.sessions import NO_CERTIFICATES
from seamark.server.accounts import accounts
from seamark.server.database.engine import Database
from tests.journey.conftest import SHORT
from tests.journey.service import Service
from tests.services import promql

pytestmark = [pytest.mark.slow, pytest.mark.host]

REQUEST = "an-operator-follows-this"
SECRET = "secret-of-the-query-string"
PROGRAM = b"""
class Controller:
    def __init__(self, config): pass
    def reset(self, level): pass
    def step(self, observation): return [0.0, 0.0, 0.0, 0.0]
"""
END_S = 240.0  # the first run on a loaded machine waits for the compiler


@dataclass(frozen=True)
class Followed:
    """A run that has ended, and who submitted it with which token."""

    id: int
    user: int
    token: str


@pytest.fixture(scope="module")
def run(service: Service) -> Followed:
    """A run of an uploaded program, submitted with an id of its own."""
    with closing(Database(f"sqlite:///{service.data / 'seamark.db'}")) as database:
        with database.writing() as session:
            user = accounts.sign_up(session, "operator", None)
            session.flush()
            token = accounts.new_token(session, user.id, "logs", ["read", "submit"])
    headers = {"Authorization": f"Bearer {token}", "X-Request-ID": REQUEST}
    with httpx.Client(base_url=service.url, headers=headers, timeout=60) as client:
        answer = client.post(
            f"/api/v1/runs?note={SECRET}",
            data={"run": json.dumps({"benchmark": "currents-v1", "config": SHORT})},
            files={"program": ("still.py", PROGRAM)},
        )
        assert answer.headers["X-Request-ID"] == REQUEST
        run_id = answer.json()["id"]
        deadline = time.monotonic() + END_S
        while client.get(f"/api/v1/runs/{run_id}").json()["state"] in ("queued", "running"):
            assert time.monotonic() < deadline
            time.sleep(0.2)
    return Followed(run_id, user.id, token)


def events(service: Service, process: str) -> list[dict[str, Any]]:
    """Return what a process has logged; each line is JSON."""
    lines = (service.data / "logs" / f"{process}.log").read_text().splitlines()
    return [json.loads(line) for line in lines]


def test_one_id_shows_the_life_of_a_run_from_its_request_to_its_result(
    service: Service, run: Followed
) -> None:
    deadline = time.monotonic() + END_S
    while True:  # a worker logs the end after it has stored it
        web, worker = (
            [event for event in events(service, process) if event.get("request") == REQUEST]
            for process in ("web", "worker")
        )
        if [event["event"] for event in worker][-1:] == ["run_ended"]:
            break
        assert time.monotonic() < deadline
        time.sleep(0.1)

    submitted = next(event for event in web if event["event"] == "run_submitted")
    assert (submitted["run"], submitted["user"]) == (run.id, run.user)
    answered = next(event for event in web if event["event"] == "request")
    assert (answered["method"], answered["route"]) == ("POST", "/api/v1/runs")
    assert (answered["status"], answered["user"]) == (202, run.user)
    assert (answered["network"], answered["complete"]) == ("127.0.0.0/24", True)
    assert [event["event"] for event in worker] == ["run_started", "run_ended"]
    assert {(e["run"], e["attempt"], e["user"]) for e in worker} == {(run.id, 1, run.user)}
    assert worker[-1]["state"] == "succeeded"
    assert worker[0]["worker"].startswith("seamark-")


def test_no_log_has_secrets_of_requests(service: Service, run: Followed) -> None:
    text = "".join(path.read_text() for path in (service.data / "logs").iterdir())

    assert REQUEST in text
    assert SECRET not in text
    assert run.token not in text


@pytest.fixture(scope="module")
def scraped(service: Service, run: Followed) -> str:
    """The metrics of the service after the run and a first round of maintenance."""
    text, deadline = "", time.monotonic() + 120.0
    while "seamark_maintenance_failures_total{" not in text:
        assert time.monotonic() < deadline
        text = httpx.get(f"{service.url}/metrics", verify=NO_CERTIFICATES).text
        time.sleep(0.2)  # nothing is announced
    return text


def test_the_metrics_have_the_run_with_its_phases_and_its_box(scraped: str) -> None:
    text = scraped

    for phase in ("starting", "preparing", "simulating", "storing"):
        assert re.search(rf'seamark_run_phase_seconds_count{{phase="{phase}"}} [1-9]', text)
    assert re.search(r'seamark_box_start_seconds_count{language="python"} [1-9]', text)
    assert re.search(r'seamark_run_waiting_seconds_count{lane="account"} [1-9]', text)
    ended = 'seamark_runs_ended_total{cause="",kind="practice",state="succeeded"} [1-9]'
    assert re.search(ended, text)
    assert re.search(r'seamark_workers{state="(ready|preparing)"} 1.0', text)  # by its heartbeat


def test_board_and_rules_refer_to_metrics_labels_and_values_that_the_service_has(
    scraped: str,
) -> None:
    exported = promql.labels_and_values(text_string_to_metric_families(scraped))

    unknown = {each: promql.unknown_in(each, exported) for each in promql.expressions()}

    assert len(unknown) > 50
    assert {each: names for each, names in unknown.items() if names} == {}
