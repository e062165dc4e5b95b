"""A set of runs is computed again by the API."""

from typing import Any

from tests.server.api.conftest import Site

API = "/api/v1/admin/rejudgements"
CHOSEN = {"benchmark": "currents-v1", "reason": "The drag was wrong"}


def test_a_rejudgement_is_started_compared_and_decided_by_the_api(site: Site) -> None:
    run_id, client, headers = site.succeeded("ann"), site.client(), site.headers["admin"]

    def get(path: str) -> Any:
        return client.get(path, headers=headers).json

    seen = get(f"{API}/preview?benchmark=currents-v1")
    made: Any = client.post(API, json=CHOSEN, headers=headers).json
    path = f"{API}/{made['id']}"
    early = client.post(f"{path}/accept", headers=headers)
    site.finish(site.claim_next(), 51.0)

    [found] = get(f"{path}/differences")["differences"]
    accepted: Any = client.post(f"{path}/accept", headers=headers).json
    again = client.post(f"{path}/discard", headers=headers)

    assert (seen["runs"], seen["complete"], made["live"]) == (1, True, 1)
    assert (early.status_code, again.status_code) == (409, 409)
    scores = (found["before"]["score"], found["after"]["score"])
    assert (found["run_id"], scores) == (run_id, (50.0, 51.0))
    assert (accepted["decision"], accepted["decided_by"]) == ("accepted", "root")
    assert [each["id"] for each in get(API)["rejudgements"]] == [made["id"]]
    assert client.get(f"{API}/{made['id'] + 1}", headers=headers).status_code == 404
