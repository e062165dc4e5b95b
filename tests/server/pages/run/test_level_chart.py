"""The chart over the levels of a run: while it goes on, at its end, and where there is none."""

import json
import re
import tracemalloc
from typing import Any

import numpy as np
import pytest

from seamark.server.runs.data.files import RunFiles
from seamark.sim.recording.telemetry import INDEX, WIDTH
from tests.server.pages.conftest import Site

VISIBILITY = {"benchmark": "visibility-v1", "controller": "built-in"}


def _curves(site: Site, run_id: int) -> list[dict[str, Any]]:
    page = site.browser("ann").get(f"/runs/{run_id}").text
    pattern = r'data-part="curve-\d"><script type="application/json">(.*?)</script>'
    return [json.loads(text) for text in re.findall(pattern, page)]


def _curve(site: Site, run_id: int) -> dict[str, Any] | None:
    return next(iter(_curves(site, run_id)), None)


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


def test_who_looks_at_a_run_needs_the_memory_of_one_level_however_long_the_run_is(
    site: Site,
) -> None:
    claim = site.running("ann", **VISIBILITY)
    files = RunFiles(site.settings.data, claim.run_id, claim.attempt)
    for level in range(10):
        rows = np.repeat(_rows(0, [0.5]), 1000, axis=0)  # 2 MB
        rows[:, INDEX["level"]] = level
        files.append_rows(rows)
    before = _curve(site, claim.run_id)

    tracemalloc.start()
    during = _curve(site, claim.run_id)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()

    assert during == before
    assert during is not None
    assert len(during["x"]) == 9
    assert peak < files.size() * 0.75


SHORT = {"turbidity_levels": [0, 4, 7], "motion_levels": [4, 9], "jump_levels": [2, 8]}
AXES = (
    *(("turbidity", 7.0), ("turbidity", 4.0), ("turbidity", 0.0)),
    *(("motion", 9.0), ("motion", 4.0), ("jump", 8.0), ("jump", 2.0)),
)


def test_every_axis_has_its_chart_in_rising_order_with_the_area_under_it(site: Site) -> None:
    claim = site.running("ann", benchmark="visibility-v2", controller="built-in", config=SHORT)
    levels = [
        {"level": k, "axis": axis, "value": value, "p5_percent": 100 - 10 * value, "p1_percent": k}
        for k, (axis, value) in enumerate(AXES)
    ]
    score = {"score": 4.5, "score_low": None, "score_high": None, "level_held": 4.0}
    overall = {"motion_held_px": 6.25, "basin_px": 5.5}
    assert site.finish(claim, metrics=score | {"overall": overall, "levels": levels, "trials": []})

    turbidity, motion, jump = _curves(site, claim.run_id)

    assert [curve["x"] for curve in (turbidity, motion, jump)] == [[0, 4, 7], [4, 9], [2, 8]]
    assert turbidity["lines"][0]["values"] == [100.0, 60.0, 30.0]
    assert jump["lines"][0]["values"] == [6.0, 5.0]  # p@1: a jump must converge
    assert [curve["mark"] for curve in (turbidity, motion, jump)] == [4.5, 6.25, 5.5]
    assert "area under p@5, is 4.50 optical depth" in turbidity["sentence"]


def test_the_charts_of_all_axes_grow_during_the_run(site: Site) -> None:
    claim = site.running("ann", benchmark="visibility-v2", controller="built-in", config=SHORT)
    files = RunFiles(site.settings.data, claim.run_id, claim.attempt)
    files.append_rows(_rows(0, [9.0, 3.0, 0.5, 9.0, 0.5]))

    turbidity, motion, jump = _curves(site, claim.run_id)

    assert turbidity["x"] == [0, 4, 7]
    assert turbidity["lines"][0]["values"] == [100.0, 100.0, 0.0]
    assert (motion["x"], jump["x"]) == ([9], [])
    assert motion["mark"] is None


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
