"""What a detector recognised, over the API, and the bottom that it saw."""

import cv2
import numpy as np
import pytest

from seamark.sim.recording.telemetry import DETECTION_COLUMNS
from tests.server.api.conftest import Site


def test_a_run_without_a_detector_has_no_levels_of_recognition(site: Site) -> None:
    path = f"/api/v1/runs/{site.recorded()}/recognition.json"

    first = site.call("owner", "GET", path)
    again = site.call("owner", "GET", path, headers={"If-None-Match": first.headers["ETag"]})

    assert first.get_json()["levels"] == []
    assert again.status_code == 304


@pytest.mark.slow
def test_the_scene_of_a_detector_is_the_bottom_of_its_level_without_a_target(site: Site) -> None:
    path = f"/api/v1/runs/{site.succeeded(benchmark='patterns-v1', controller='built-in')}"

    scene = site.call("owner", "GET", f"{path}/scene.json?level=1").get_json()
    first, second = (
        np.asarray(cv2.imdecode(np.frombuffer(site.call("owner", "GET", one).data, np.uint8), 1))
        for one in (f"{path}/texture.jpg?part=seabed&level={level}" for level in (0, 1))
    )

    assert (scene["target"], scene["vehicle"]) == (None, None)
    assert scene["seabed"]["painted"]
    assert np.abs(first.astype(int) - second).mean() > 1.0  # both may be sand, with other things


def test_the_page_of_a_detector_lists_no_column_that_says_nothing(site: Site) -> None:
    run_id = site.succeeded(benchmark="patterns-v1", controller="built-in")

    page = site.call("owner", "GET", f"/runs/{run_id}").text

    assert "data-recognition" in page
    assert "missed object" in page
    for absent in ("Zoom to target", "Largest error", "line to the target", '"tracker_ok"'):
        assert absent not in page
    assert not any(f'"{column.name}"' in page for column in DETECTION_COLUMNS)
