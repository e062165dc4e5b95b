"""The page of a log of a mission: what it has, and nothing of what it lacks."""

import io
import json
import re
from typing import Any

import numpy as np
import pytest

from tests.server.pages.conftest import Site

POSE = ("t", "x", "y", "z", "roll", "pitch", "yaw")
CORNERS = tuple(f"corner_{index}" for index in range(8))


def _log(names: tuple[str, ...], rows: int = 40) -> bytes:
    values = np.zeros((rows, len(names)))
    values[:, 0] = 0.05 * np.arange(rows)
    values[:, 3] = 1.65
    lines = [",".join(map(repr, row)) for row in values.tolist()]
    return "\n".join([",".join(names), *lines]).encode()


def _opened(site: Site, names: tuple[str, ...]) -> str:
    """Open a log as the form does, and return its page."""
    form = {"benchmark": "currents-v1", "mapping": "settings = {settle_s = 0}"}
    file = {"log": (io.BytesIO(_log(names)), "pool.csv")}
    answer = site.browser("ann").post("/logs/new", form | file, follow_redirects=True)
    assert "Log of a real mission" in answer.text, answer.text[:2000]
    return answer.text


def _data(page: str) -> dict[str, Any]:
    found = re.search(r'id="run-data">(.*?)</script>', page, re.DOTALL)
    assert found is not None
    data: dict[str, Any] = json.loads(found.group(1))
    return data


@pytest.fixture
def page(site: Site) -> str:
    return _opened(site, POSE)


@pytest.mark.slow
def test_a_log_without_a_tracker_says_nothing_about_a_tracker(page: str) -> None:
    shown = page[page.index("<main") : page.index("Columns and origin")]
    of_tracker = ("tracker", "Target first lost", "Ground truth", "target was lost")

    assert [words for words in of_tracker if words in shown] == []
    assert "tracker_ok" not in {column["name"] for column in _data(page)["columns"]}


@pytest.mark.slow
def test_a_log_without_a_tracker_shows_metres(page: str) -> None:
    units = {chart["unit"] for chart in _data(page)["charts"]}

    assert "m" in units
    assert "px" not in units
    assert '<span class="unit">[px]</span>' not in page
    assert re.search(r"<dt>RMSE of the distance</dt><dd>[\d.]+ <small>m</small>", page)


@pytest.mark.slow
def test_a_log_has_no_table_of_dashes(page: str) -> None:
    tables = page[page.index("metrics-title") : page.index("log-origin-title")]

    assert 'scope="row"' in tables
    assert '<td class="num">–</td>' not in tables


@pytest.mark.slow
def test_a_log_with_corners_shows_pixels_and_its_tracker(site: Site) -> None:
    page = _opened(site, (*POSE, *CORNERS))

    assert "tracker&#39;s estimate" in page or "tracker's estimate" in page
    assert "px" in {chart["unit"] for chart in _data(page)["charts"]}
