"""The chart over the levels of a run: while it goes on, at its end, and where there is none."""

import json
import re
from typing import Any

import numpy as np
import pytest

from seamark.server.runs.files import RunFiles
from seamark.sim.recording.telemetry import INDEX, WIDTH
from tests.server.pages.conftest import Site

VISIBILITY = {"benchmark": "visibility-v1", "controller": "built-in"}


def _curve(site: Site, run_id: int) -> dict[str, Any] | None:
    page = site.browser("ann").get(f"/runs/{run_id}").text
    found = re.search(r'data-part="curve"><script type="application/json">(.*?)</script>', page)
    return None if found is None else json.loads(found.group(1))


def _rows(trial: int, errors_px: list[float]) -> np.ndarray:
    """Five rows of each level, all with the same corner error."""
    rows = np.zeros((5 * len(errors_px), WIDTH))
    rows[:, INDEX["trial"]] = trial
    rows[:, INDEX["level"]] = np.repeat(np.arange(len(errors_px)), 5)
    rows[:, INDEX["tracker_ok"]] = 1.0
    rows[:, INDEX["tracker_error"]] = np.repeat(errors_px, 5)
    return rows


def test_the_chart_grows_by_the_completed_levels(site: Site) -> None:
    claim = site.running("ann", **VISIBILITY)
    files = RunFiles(site.settings.data, claim.run_id, claim.attempt)
    before = _curve(site, claim.run_id)
    files.append_rows(_rows(0, [0.5, 3.0, 0.5]))
    during = _curve(site, claim.run_id)

    assert before is not None
    assert during is not None
    assert before["x"] == []
    assert during["x"] == [0.0, 0.25]  # the third level may still go on
    assert [line["values"] for line in during["lines"]] == [[100.0, 100.0], [100.0, 0.0]]
    assert during["mark"] is None


def test_the_chart_of_a_running_run_is_the_mean_of_its_trials_and_marks_the_failure_so_far(
    site: Site,
) -> None:
    claim = site.running("ann", **VISIBILITY, trials=2)
    files = RunFiles(site.settings.data, claim.run_id, claim.attempt)
    files.append_rows(_rows(0, [0.5, 9.0]))
    files.append_rows(_rows(1, [9.0, 9.0, 9.0]))

    curve = _curve(site, claim.run_id)

    assert curve is not None
    assert curve["lines"][0]["values"] == [50.0, 0.0]
    assert curve["mark"] == 0.25


def test_the_chart_of_a_run_that_ended_shows_its_metrics_and_marks_its_score(site: Site) -> None:
    claim = site.running("ann", **VISIBILITY)
    levels = [
        {"level": k, "value": k / 4, "optical_depth": k / 4, "p5_percent": p5, "p1_percent": p1}
        for k, (p5, p1) in enumerate([(100.0, 90.0), (80.0, 20.0), (10.0, 0.0)])
    ]
    score = {"score": 0.5, "score_low": None, "score_high": None, "level_held": 0.25}
    assert site.finish(claim, metrics=score | {"levels": levels, "trials": []})

    curve = _curve(site, claim.run_id)

    assert curve is not None
    assert curve["lines"][0]["values"] == [100.0, 80.0, 10.0]
    assert curve["mark"] == 0.5
    assert "τ50, where p@5 falls below 50 %, is 0.50." in curve["sentence"]


def test_a_benchmark_of_controllers_has_no_level_chart(site: Site) -> None:
    assert _curve(site, site.succeeded("ann")) is None


@pytest.mark.parametrize(
    ("config", "shown", "left_out"),
    [
        ({"tracker": "klt"}, ["Points", "Path amplitude"], ["Similarity", "Current"]),
        ({"tracker": "kcf", "mode": "free"}, ["Current"], ["Warp", "Path amplitude"]),
        ({}, ["Similarity", "Sampling"], ["Points", "Homography as SL(3)"]),
    ],
)
def test_the_page_of_a_run_lists_the_options_that_applied(
    site: Site, config: dict[str, object], shown: list[str], left_out: list[str]
) -> None:
    run_id = site.queue("ann", **VISIBILITY, config=config)

    page = site.browser("ann").get(f"/runs/{run_id}").text
    options = set(re.findall(r"<dt>(.*?)</dt>", page))
    whole = site.browser("ann").get(f"/api/v1/runs/{run_id}/config.json").text

    assert set(shown) <= options
    assert not set(left_out) & options
    assert "klt_points" in whole
