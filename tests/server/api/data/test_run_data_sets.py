"""The data set of a run: what its manifest claims, and where there is none."""

import io
import json
import zipfile
from typing import Any

from tests.server.api.conftest import Site

RUNS = "/api/v1/runs"


def _manifest(data: bytes) -> dict[str, Any]:
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        (name,) = (name for name in archive.namelist() if name.endswith("manifest.json"))
        manifest: dict[str, Any] = json.loads(archive.read(name))
    return manifest


def test_a_ranked_run_on_fresh_water_has_a_data_set_with_the_seed_of_the_trial(site: Site) -> None:
    run_id = site.succeeded(kind="ranked", benchmark="currents-v2")
    site.record(run_id, rows=40)

    answer = site.call("owner", "GET", f"{RUNS}/{run_id}/dataset.zip")

    manifest = _manifest(answer.data)
    assert manifest["seed"] == 2026


def test_a_data_set_of_an_upload_does_not_claim_the_same_bits_everywhere(site: Site) -> None:
    run_id = site.recorded()

    answer = site.call("owner", "GET", f"{RUNS}/{run_id}/dataset.zip?every=100")

    manifest = _manifest(answer.data)
    assert manifest["program_sha256"] == site.show(run_id).program_sha256
    assert manifest["same_bits_on_every_cpu"] is False


def test_a_ranked_run_of_a_first_version_has_no_data_set(site: Site) -> None:
    run_id = site.succeeded(kind="ranked")
    site.record(run_id, rows=40)

    answer = site.call("owner", "GET", f"{RUNS}/{run_id}/dataset.zip")

    assert answer.status_code == 409
    assert "hidden seeds" in json.loads(answer.data)["detail"]


def test_a_run_of_a_detector_has_no_data_set_but_says_how_to_draw_images(site: Site) -> None:
    run_id = site.succeeded(benchmark="patterns-v1", controller="built-in", title="")

    answer = site.call("owner", "GET", f"{RUNS}/{run_id}/dataset.zip")

    assert answer.status_code == 409
    assert "seamark dataset patterns-v1 --images" in json.loads(answer.data)["detail"]


def test_a_run_on_a_route_has_no_data_set(site: Site) -> None:
    run_id = site.succeeded(benchmark="track-v1", controller="ilos")

    answer = site.call("owner", "GET", f"{RUNS}/{run_id}/dataset.zip")

    assert answer.status_code == 409
    assert "nothing in it is done by images" in json.loads(answer.data)["detail"]
