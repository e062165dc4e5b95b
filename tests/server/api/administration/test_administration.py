"""The administration by the API: as its pages, for scripts of an operator."""

from typing import Any

import pytest

from seamark.server.database.tables import Worker
from seamark.server.messaging import workers
from seamark.server.runs.data import disk_usage
from tests.server.api.conftest import Site

ADMIN = "/api/v1/admin"


def _register(site: Site) -> None:
    with site.database.writing() as session:
        row = Worker(name="w1@host", slots=2, level="strong", languages=["python"], findings=[])
        workers.register(session, row)


def _get(site: Site, path: str) -> Any:
    return site.client().get(f"{ADMIN}{path}", headers=site.headers["admin"]).json


@pytest.mark.slow
def test_a_worker_is_drained_and_resumed_by_the_api(site: Site) -> None:
    _register(site)
    client, path = site.client(), f"{ADMIN}/workers/w1@host"

    def claims(drained: bool) -> bool:
        answer = client.patch(path, json={"drained": drained}, headers=site.headers["admin"])
        shown: Any = answer.json
        assert (answer.status_code, bool(shown["drained_at"])) == (200, drained)
        run_id = site.queue("ann")
        claimed = site.claim("w1@host/0") is not None
        site.cancel(run_id)
        return claimed

    assert [claims(True), claims(True), claims(False)] == [False, False, True]
    assert [entry["action"] for entry in _get(site, "/audit")["entries"]] == [
        "worker_resumed",
        "worker_drained",
    ]


def test_an_account_is_changed_in_one_transaction_or_not_at_all(site: Site) -> None:
    client, root = site.client(), f"/users/{site.user_id('root')}"
    change: dict[str, Any] = {"quota_day": 3, "disabled": True}

    refused = client.patch(f"{ADMIN}{root}", json=change, headers=site.headers["admin"])

    assert refused.status_code == 409
    shown = _get(site, root)
    assert (shown["quota_day"], shown["disabled_at"]) == (None, None)
    assert _get(site, "/audit")["entries"] == []


def test_a_deleted_account_is_gone_from_the_list_at_once(site: Site) -> None:
    client, headers = site.client(), site.headers["admin"]
    path = f"{ADMIN}/users/{site.user_id('ann')}"

    assert client.delete(path, headers=headers).status_code == 204

    assert client.get(path, headers=headers).status_code == 404
    listed = _get(site, "/users?q=a")["users"]
    assert [user["name"] for user in listed] == ["olga", "eva"]


def test_the_queue_has_the_runs_that_start_next_and_those_that_run(site: Site) -> None:
    running = site.running("ann").run_id
    waiting = [site.queue(who) for who in ("ann", "ben")]

    found = _get(site, "/queue")

    assert found["queued"] == 2
    assert [run["id"] for run in found["running"]] == [running]
    assert [run["id"] for run in found["waiting"]] == waiting[::-1]
    assert [run["user"] for run in found["waiting"]] == ["ben", "ann"]


def test_the_storage_is_measured_and_retention_can_be_asked_for(site: Site) -> None:
    disk_usage.measure(site.database, site.settings)
    path, headers = f"{ADMIN}/storage/retention", site.headers["admin"]

    asked = site.client().post(path, headers=headers)

    found = _get(site, "/storage")
    assert asked.status_code == 202
    assert found["requested_at"] > 0
    assert {area["name"] for area in found["areas"]} == {"runs", "database"}
    assert found["backup_at"] is None
