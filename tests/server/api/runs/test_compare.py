"""Runs side by side over HTTP: the document, its errors, series on one axis."""

from typing import Any

import numpy as np

from seamark.server.runs.data.files import RunFiles
from seamark.sim.recording.telemetry import INDEX, WIDTH
from tests.server.api.conftest import Site

COMPARE = "/api/v1/compare"
SHORT = {"levels": [0.1, 0.3], "level_duration_s": 4.0, "settle_s": 1.0}


def _finished(site: Site, who: str = "ann", *, levels: tuple[int, ...] = (), **changes: Any) -> int:
    """Return a practice run with a score; its telemetry has levels of 4 s in this order."""
    run_id = site.succeeded(who, **{"seed": 7, "config": SHORT} | changes)
    rows = np.zeros((80 * len(levels), WIDTH))
    rows[:, INDEX["t"]] = 0.05 * np.arange(len(rows))
    rows[:, INDEX["level"]] = np.repeat(levels, 80)
    rows[:, INDEX["distance"]] = 10 * run_id + rows[:, INDEX["level"]]
    RunFiles(site.settings.data, run_id, 1).append_rows(rows)
    return run_id


def test_a_comparison_has_what_differs_and_series_on_one_axis(site: Site) -> None:
    first = _finished(site, levels=(0, 1))
    second = _finished(site, levels=(1, 0), config=SHORT | {"kp": 0.6})
    path = f"{COMPARE}?runs={first},{second}&columns=distance&level=1"

    answer = site.call("owner", "GET", path)
    again = site.call("owner", "GET", path, headers={"If-None-Match": answer.headers["ETag"]})

    found = answer.get_json()
    assert [run["id"] for run in found["runs"]] == [first, second]
    assert [(row["name"], row["values"]) for row in found["settings"]] == [("kp", ["0.5", "0.6"])]
    assert [(each["run"], each["other"]) for each in found["scores"]] == [(second, first)]
    assert found["levels"] == ["0.1 m/s", "0.3 m/s"]
    assert [each["start_s"] for each in found["series"]] == [4.0, 0.0]
    assert [(each["t"][0], each["t"][-1]) for each in found["series"]] == [(0.0, 3.95)] * 2
    distances = [set(each["columns"]["distance"]) for each in found["series"]]
    assert distances == [{10.0 * first + 1.0}, {10.0 * second + 1.0}]
    assert again.status_code == 304


def test_a_wrong_request_says_what_to_send(site: Site) -> None:
    assert [_finished(site), _finished(site)] == [1, 2]

    for field, query in (
        ("runs", "runs=1"),
        ("runs", "runs=1,1"),
        ("runs", "runs=1,x"),
        ("runs", "runs=1,2,3,4,5,6"),
        ("runs", f"runs=1,{10**40}"),
        ("runs", ""),
        ("columns", "runs=1,2&columns=nope"),
        ("level", "runs=1,2&level=-1"),
    ):
        answer = site.call("owner", "GET", f"{COMPARE}?{query}")
        assert answer.status_code == 422
        assert [error["field"] for error in answer.get_json()["errors"]] == [field]


def test_a_private_run_of_somebody_else_cannot_be_compared_with(site: Site) -> None:
    own, private = _finished(site), _finished(site, "ben")

    answer = site.call("owner", "GET", f"{COMPARE}?runs={own},{private}")

    assert answer.status_code == 404
