"""Runs of earlier versions stay readable, whatever a later version accepts."""

import io

import numpy as np
import pytest

from seamark.server.database.tables import Run
from seamark.server.runs.data.files import RunFiles
from seamark.sim.recording.telemetry import WIDTH
from tests.server.pages.conftest import Site

OLD = {
    "a value that is now out of range": {"kp": 99.0},
    "a setting that is gone": {"kp": 99.0, "gone": "x"},
    "a choice that is gone": {"kp": 99.0, "vehicle": "gone-v0"},
}


@pytest.fixture(params=list(OLD.values()), ids=list(OLD))
def old_run(site: Site, request: pytest.FixtureRequest) -> int:
    """A public run with a configuration that is no longer valid; settings are missing, too."""
    run_id = site.published("ann")
    RunFiles(site.settings.data, run_id, 1).append_rows(np.zeros((3, WIDTH)))
    with site.database.writing() as session:
        session.get_one(Run, run_id).config = dict(request.param)
    return run_id


@pytest.mark.slow
@pytest.mark.parametrize(
    "path",
    [
        *("/runs/{}", "/runs/", "/", "/api/v1/runs/{}", "/api/v1/runs/{}/telemetry.csv"),
        *("/api/v1/runs/{}/config.json", "/submit/currents-v1?from={}", "/runs/runs.csv"),
    ],
)
def test_a_run_is_shown_whatever_its_configuration(site: Site, old_run: int, path: str) -> None:
    assert site.browser("ann").get(path.format(old_run)).status_code == 200


@pytest.mark.parametrize("path", ["/runs/{}", "/runs/", "/api/v1/runs/{}/telemetry.csv"])
def test_a_run_without_any_setting_of_today_is_shown(site: Site, path: str) -> None:
    run_id = site.succeeded("ann", benchmark="visibility-v1", controller="built-in")
    with site.database.writing() as session:
        session.get_one(Run, run_id).config = {"gone": 1}

    assert site.browser("ann").get(path.format(run_id)).status_code == 200


def test_running_it_again_shows_what_is_no_longer_accepted(site: Site, old_run: int) -> None:
    browser = site.browser("ann")

    form = browser.get(f"/submit/currents-v1?from={old_run}")
    answer = browser.post("/submit/currents-v1", {"controller": "pi", "kp": "99"})

    assert 'value="99"' in form.text
    assert (answer.status_code, 'id="kp-error"' in answer.text) == (422, True)


def test_running_it_again_through_the_api_names_the_settings(site: Site, old_run: int) -> None:
    browser = site.browser("ann")

    answer = browser.client.post(
        f"/api/v1/runs/{old_run}/rerun", headers={"X-CSRFToken": browser.csrf_token()}
    )

    problem = answer.get_json()
    assert answer.status_code == 422
    assert "kp" in {error["field"] for error in problem["errors"]}


def test_the_camera_image_of_a_run_with_a_value_out_of_range_is_rendered(site: Site) -> None:
    run_id = site.succeeded("ann")
    RunFiles(site.settings.data, run_id, 1).append_rows(np.zeros((3, WIDTH)))
    with site.database.writing() as session:
        session.get_one(Run, run_id).config = {"kp": 99.0, "gone": "x"}

    image = site.browser("ann").get(f"/api/v1/runs/{run_id}/camera.jpg?trial=0&t=0")

    assert image.status_code == 200
    assert io.BytesIO(image.data).read(2) == b"\xff\xd8"
