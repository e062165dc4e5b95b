"""Runs compared on the water that they share."""

import pytest

from tests.server.api.conftest import Site

RUNS = "/api/v1/runs"


def test_two_ranked_runs_are_compared_on_their_reference_trials(site: Site) -> None:
    ids = []
    for score in (0.4, 0.3):
        claim = site.running(
            "ann", kind="ranked", benchmark="currents-v2", config={"kp": 1.0 + score}
        )
        trials = [{"score": score + 0.1 * at, "part": "reference"} for at in (1, 2, 3, 4)]
        assert site.finish(claim, metrics={"score": score, "trials": trials})
        ids.append(claim.run_id)

    answer = site.call("owner", "GET", f"{RUNS}/{ids[0]}/comparison?with={ids[1]}").get_json()
    refused = site.call("owner", "GET", f"{RUNS}/{ids[0]}/comparison?with={site.succeeded('ann')}")

    assert (answer["run"], answer["other"], answer["trials"]) == (*ids, 4)
    assert answer["difference"] == pytest.approx(0.1)
    assert answer["low"] == pytest.approx(answer["high"]) == pytest.approx(0.1)
    assert refused.status_code == 422


def test_a_private_run_of_somebody_else_cannot_be_compared_with(site: Site) -> None:
    own, private = site.succeeded("ann", kind="ranked"), site.succeeded("ben", kind="ranked")

    answer = site.call("owner", "GET", f"{RUNS}/{own}/comparison?with={private}")

    assert answer.status_code == 404
