"""Sweeps in the form and on their page, for each role; and through the API."""

import re

import pytest

from seamark.server.runs.record.states import RunState
from tests.server.pages.conftest import Browser, Site

FORM = "/submit/currents-v1"
SWEEP = {"controller": "pi", "sweep-0-name": "kp", "sweep-0-values": "0.2, 0.4, 0.6"}
TWO = SWEEP | {"sweep-1-name": "ki", "sweep-1-values": "0:0.04:3"}


def _started(browser: Browser, **changes: str) -> int:
    answer = browser.post(FORM, TWO | changes)
    assert answer.status_code == 303, re.findall(r'class="error[^>]*>[^<]*', answer.text)
    found = re.fullmatch(r"/sweeps/(\d+)", answer.headers["Location"])
    assert found is not None
    return int(found[1])


def test_a_sweep_of_two_settings_is_a_heat_map_with_its_best_point(site: Site) -> None:
    browser = site.browser("ann")
    sweep_id = _started(browser)
    before = browser.get(f"/sweeps/{sweep_id}").text
    runs = [site.claim_next() for _ in range(3)]
    for claim, score in zip(runs, (40.0, 70.0, 55.0), strict=True):
        site.finish(claim, score=score)

    page = browser.get(f"/sweeps/{sweep_id}").text

    assert "No run has a score yet." in before
    assert 'class="heat-map"' in page
    assert "3 of 9 runs finished" in page
    best = page[page.index('id="best-title"') : page.index('id="map-title"')]
    assert f'/runs/{runs[1].run_id}"' in best
    assert f"?from={runs[1].run_id}" in best
    assert ("heat-0" in page, "heat-7 best" in page, "no-score" in page) == (True, True, True)


def test_a_sweep_of_one_setting_is_a_curve(site: Site) -> None:
    browser = site.browser("ann")
    sweep_id = _started(browser, **{"sweep-1-name": "", "sweep-1-values": ""})
    for score in (40.0, 70.0, 55.0):
        site.finish(site.claim_next(), score=score)

    page = browser.get(f"/sweeps/{sweep_id}").text

    chart = page[page.index("sweep-curve") : page.index('id="runs-title"')]
    assert chart.count("cx=") == 3
    assert page.count('class="whisker"') == 3
    assert "data-live" not in page


def test_a_sweep_that_is_refused_is_explained_in_the_form(site: Site) -> None:
    answer = site.browser("ann").post(FORM, SWEEP | {"sweep-0-values": "0:1"})

    assert answer.status_code == 422
    assert "write a range as from:to:count" in answer.text
    assert 'value="0:1"' in answer.text


@pytest.mark.parametrize(
    ("changes", "label"),
    [
        ({}, "Start 3 runs"),
        ({"sweep-1-name": "ki", "sweep-1-values": "0:0.04:3"}, "Start 9 runs"),
        ({"sweep-0-name": ""}, "Start run"),
        ({"sweep-0-values": "0:1"}, "Start run"),
        ({"kind": "ranked"}, "Start run"),
    ],
)
def test_the_button_of_a_form_that_is_shown_again_says_how_many_runs_it_starts(
    site: Site, changes: dict[str, str], label: str
) -> None:
    answer = site.browser("ann").post(FORM, SWEEP | {"level_duration_s": "x"} | changes)

    assert answer.status_code == 422
    assert f"<span data-submit-label>{label}</span>" in answer.text


@pytest.mark.slow
def test_the_page_of_a_sweep_warns_if_the_best_point_is_at_its_edge(site: Site) -> None:
    browser = site.browser("ann")
    sweep_id = _started(browser, **{"sweep-1-name": "", "sweep-1-values": ""})
    for score in (40.0, 50.0, 70.0):
        site.finish(site.claim_next(), score=score)

    page = browser.get(f"/sweeps/{sweep_id}").text

    (warning,) = re.findall(r"data-edge>([^<]+)<", page)
    assert "of this sweep, 0.6 1/s. Try larger values" in warning


@pytest.mark.parametrize(("who", "status"), [("stranger", 404), ("ben", 404), ("root", 200)])
def test_a_sweep_is_its_owners(site: Site, who: str, status: int) -> None:
    sweep_id = _started(site.browser("ann"))

    assert site.browser(who).get(f"/sweeps/{sweep_id}").status_code == status
    assert site.browser(who).get(f"/api/v1/sweeps/{sweep_id}").status_code == status


def test_cancel_all_cancels_the_runs_and_nobody_else_can(site: Site) -> None:
    sweep_id = _started(site.browser("ann"))

    refused = site.browser("ben").post(f"/sweeps/{sweep_id}/cancel").status_code
    answer = site.browser("ann").post(f"/sweeps/{sweep_id}/cancel")

    cells = site.browser("ann").get(f"/api/v1/sweeps/{sweep_id}").get_json()["cells"]
    assert (refused, answer.status_code) == (404, 303)
    assert {cell["run"]["state"] for cell in cells} == {RunState.CANCELLED}


def test_the_api_starts_a_sweep_and_shows_its_cells(site: Site) -> None:
    browser = site.browser("ann")
    body = {"benchmark": "currents-v1", "controller": "pi", "seed": 4}
    axes = [{"name": "kp", "values": [0.2, 0.4]}, {"name": "tracker", "values": "truth, esm"}]

    answer = browser.client.post(
        "/api/v1/sweeps",
        json=body | {"sweep": axes},
        headers={"X-CSRFToken": browser.csrf_token()},
    )

    sweep = answer.get_json()
    assert answer.status_code == 202, sweep
    assert answer.headers["Location"] == f"/api/v1/sweeps/{sweep['id']}"
    assert [cell["values"] for cell in sweep["cells"]] == [
        {"kp": kp, "tracker": tracker} for kp in (0.2, 0.4) for tracker in ("truth", "esm")
    ]
    assert {cell["run"]["seed"] for cell in sweep["cells"]} == {4}
    assert (sweep["live"], sweep["best"]) == (4, None)


@pytest.mark.parametrize(
    "axes",
    [
        [],
        [{"name": "kp", "values": []}],
        [{"name": "kp", "values": [None, 1]}],
        [{"name": "kp", "values": [[1], [2]]}],
        [{"name": "kp", "values": [1e999, 1]}],
        [{"name": "kp", "values": "0.1:0.5:3", "step": 1}],
        [{"name": "kp", "values": [0.1, 0.2]}] * 3,
    ],
)
def test_the_api_refuses_what_is_no_sweep(site: Site, axes: list[object]) -> None:
    browser = site.browser("ann")

    answer = browser.client.post(
        "/api/v1/sweeps",
        json={"benchmark": "currents-v1", "controller": "pi", "sweep": axes},
        headers={"X-CSRFToken": browser.csrf_token()},
    )

    assert answer.status_code in {400, 422}
