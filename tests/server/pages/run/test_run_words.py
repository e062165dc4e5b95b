"""What the page of a run says about its log, its settings and its score."""

import numpy as np
import pytest

from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.record.states import RunState
from seamark.server.web.template_filters import duration
from seamark.sim.recording.telemetry import width_for
from tests.server.pages.conftest import Site

TRACKER = b"""
class Tracker:
    def __init__(self, config): ...
    def start(self, image, corners): ...
    def update(self, image): ...
"""


def _page(site: Site, run_id: int) -> str:
    return site.browser("ann").get(f"/runs/{run_id}").text


def _failed_with_output(site: Site, output: str) -> int:
    claim = site.running("ann", controller="upload", program=site.store_program())
    RunFiles(site.settings.data, claim.run_id, claim.attempt).append_log(output.encode())
    assert site.finish(
        claim,
        state=RunState.FAILED,
        cause="user_error",
        metrics=None,
        detail={"title": "It failed", "sentence": "", "remedy": "", "log_tail": output[-2000:]},
    )
    return claim.run_id


def test_a_failed_run_shows_the_last_lines_of_its_log_and_each_only_once(site: Site) -> None:
    run_id = _failed_with_output(site, "".join(f"line {number} of it\n" for number in range(500)))

    page = _page(site, run_id)

    assert page.count("line 499 of it") == 1
    assert page.count("line 490 of it") == 1
    assert "line 0 of it" not in page
    assert f'href="/api/v1/runs/{run_id}/log"' in page


def test_a_program_that_printed_nothing_is_not_said_to_have_printed_nothing_so_far(
    site: Site,
) -> None:
    claim = site.running("ann", controller="upload", program=site.store_program())
    running = _page(site, claim.run_id)
    assert site.finish(claim)

    ended = _page(site, claim.run_id)

    assert "The program has not printed anything yet." in running
    assert "The program printed nothing." in ended
    assert "yet" not in ended[ended.index("log-title") :]


def test_an_uploaded_tracker_is_shown_without_the_options_of_the_built_in_one(site: Site) -> None:
    program = site.store_program(TRACKER, "mine.py", role="tracker")
    uploaded = site.queue(benchmark="visibility-v2", controller="upload", program=program)
    built_in = site.queue(benchmark="visibility-v2", controller="built-in")

    pages = [_page(site, run_id) for run_id in (uploaded, built_in)]

    assert ["Pyramid levels" in page for page in pages] == [False, True]
    assert ["Camera altitude" in page for page in pages] == [True, True]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("config", "marked"),
    [({}, False), ({"kp": 0.3}, False), ({"levels": [0.0, 0.1], "level_duration_s": 60}, True)],
)
def test_a_score_is_marked_where_the_scenario_is_not_that_of_the_benchmark(
    site: Site, config: dict[str, object], marked: bool
) -> None:
    run_id = site.succeeded("ann", config=config)

    pages = [_page(site, run_id), site.browser("ann").get("/runs/").text]

    assert ["changed scenario" in page for page in pages] == [marked, marked]


@pytest.mark.parametrize(
    ("seconds", "text"),
    [
        (9.94, "9.9 s"),
        (9.97, "10 s"),
        (59.4, "59 s"),
        (59.7, "1 min"),
        (599.7, "10 min"),
        (3599.6, "1 h"),
        (3661, "1 h 1 min"),
    ],
)
def test_a_duration_never_has_sixty_of_a_unit(seconds: float, text: str) -> None:
    assert duration(seconds) == text


@pytest.mark.parametrize(
    ("benchmark", "offered"), [("visibility-v2", True), ("patterns-v1", False)]
)
def test_only_a_run_whose_images_are_a_data_set_offers_them(
    site: Site, benchmark: str, offered: bool
) -> None:
    run_id = site.succeeded(benchmark=benchmark, controller="built-in")
    width = width_for(0, detections=not offered)
    RunFiles(site.settings.data, run_id, 1).append_rows(np.zeros((20, width)))

    page = _page(site, run_id)

    assert f"/api/v1/runs/{run_id}/manifest.json" in page
    assert (f"/api/v1/runs/{run_id}/dataset.zip" in page) == offered
