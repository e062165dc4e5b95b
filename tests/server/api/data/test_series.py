"""Ranges and samples of a trial's telemetry."""

from typing import Any

import numpy as np
import pytest

from seamark.server.runs.data.files import RunFiles
from seamark.sim.recording.telemetry import INDEX, WIDTH
from tests.server.api.conftest import Site

ROWS = 40_000  # 2000 s: more than is read at once


@pytest.fixture
def long_run(site: Site) -> int:
    run_id = site.succeeded(controller="p")
    table = np.zeros((ROWS, WIDTH))
    table[:, INDEX["t"]] = 0.05 * np.arange(ROWS)
    table[:, INDEX["x"]] = np.sin(0.01 * np.arange(ROWS))
    table[:, INDEX["y"]] = np.arange(ROWS)
    table[23_456, INDEX["x"]] = 7.0
    RunFiles(site.settings.data, run_id, 1).append_rows(table)
    return run_id


def _series(site: Site, run_id: int, query: str) -> dict[str, Any]:
    answer = site.call("owner", "GET", f"/api/v1/runs/{run_id}/series.json?{query}")
    assert answer.status_code == 200, answer.text
    document: dict[str, Any] = answer.get_json()
    return document


@pytest.mark.slow
@pytest.mark.parametrize(("start", "stop"), [(0.0, 1999.95), (100.0, 130.0), (1999.9, 5000.0)])
@pytest.mark.parametrize("points", [10, 300, 20_000])
def test_sampled_rows_are_rows_of_the_run_with_the_first_and_the_last_of_the_range(
    site: Site, long_run: int, start: float, stop: float, points: int
) -> None:
    query = f"columns=x,y&sample=rows&start={start}&stop={stop}&max_points={points}"

    found = _series(site, long_run, query)

    at = np.array(found["columns"]["y"])
    assert len(at) <= points
    assert found["t"] == pytest.approx(0.05 * at)
    assert found["columns"]["x"] == pytest.approx(
        np.where(at == 23_456, 7.0, np.sin(0.01 * at)), rel=1e-6
    )
    assert at[0] == round(start / 0.05)
    assert at[-1] == min(round(stop / 0.05), ROWS - 1)


def test_the_extremes_of_a_long_trial_have_its_single_peak(site: Site, long_run: int) -> None:
    found = _series(site, long_run, "columns=x&max_points=100")

    assert len(found["t"]) <= 100
    assert max(found["columns"]["x"]) == 7.0
    assert (np.diff(found["t"]) >= 0).all()


@pytest.mark.slow
def test_a_range_outside_the_trial_is_empty(site: Site, long_run: int) -> None:
    for sample in ("rows", "extremes"):
        found = _series(site, long_run, f"columns=x&sample={sample}&start=3000&stop=3010")

        assert (found["t"], found["columns"], found["rows"]) == ([], {"x": []}, 0)


def test_a_range_that_ends_before_it_begins_is_empty(site: Site, long_run: int) -> None:
    assert _series(site, long_run, "columns=x&sample=rows&start=20&stop=10")["t"] == []
