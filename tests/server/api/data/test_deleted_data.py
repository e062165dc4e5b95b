"""Data that an owner deletes: what stays, and what says that they are gone."""

import pytest

from tests.server.api.conftest import Site


def _delete(site: Site) -> str:
    """Return the address of a run in the API whose data its owner has deleted."""
    path = f"/api/v1/runs/{site.recorded()}"
    assert site.call("owner", "DELETE", f"{path}/data").status_code == 200
    return path


def test_the_result_of_a_run_stays_without_its_data(site: Site) -> None:
    path = _delete(site)

    run = site.call("owner", "GET", path).get_json()
    assert (run["data_bytes"], run["result"]["score"]) == (0, 50.0)
    assert run["data_deleted_at"] is not None
    for file in ("metrics.json", "manifest.json", "config.json"):
        assert site.call("owner", "GET", f"{path}/{file}").status_code == 200


@pytest.mark.slow
def test_deleted_files_are_gone_not_empty(site: Site) -> None:
    path = _delete(site)

    rows = ("telemetry.csv", "telemetry.f64", "telemetry.parquet", "archive.zip")
    for file in (*rows, "series.json?columns=x", "log", "camera.jpg"):
        answer = site.call("owner", "GET", f"{path}/{file}")
        assert (answer.status_code, answer.get_json()["type"]) == (410, "/problems/data-deleted")
        assert "was deleted on 20" in answer.get_json()["detail"]


def test_data_are_deleted_once(site: Site) -> None:
    path = _delete(site)

    assert site.call("owner", "DELETE", f"{path}/data").status_code == 409


def test_a_run_without_its_data_is_not_published_and_its_page_offers_nothing(site: Site) -> None:
    path = _delete(site)

    answer = site.call("owner", "POST", f"{path}/publish")
    page = site.call("owner", "GET", path.removeprefix("/api/v1")).text

    assert (answer.status_code, "has its data" in answer.get_json()["detail"]) == (409, True)
    assert "The data of this run was deleted on 20" in page
    assert [word in page for word in ("/publish", "/delete-data", "telemetry.csv")] == [False] * 3


def test_the_data_of_live_and_of_public_runs_stay(site: Site) -> None:
    public, live = site.publish(site.recorded()), site.running("ann").run_id

    for run_id in (public, live):
        answer = site.call("owner", "DELETE", f"/api/v1/runs/{run_id}/data")
        assert answer.status_code == 409
    assert "hello" in site.client().get(f"/api/v1/runs/{public}/log").text


def test_the_data_of_others_stay(site: Site) -> None:
    run_id = site.recorded()

    assert site.call("other", "DELETE", f"/api/v1/runs/{run_id}/data").status_code == 404
    assert "hello" in site.call("owner", "GET", f"/api/v1/runs/{run_id}/log").text
