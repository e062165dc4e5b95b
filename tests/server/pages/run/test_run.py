"""The page of a run in each of its states, and hostile text on it."""

import json
import math
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from seamark.formats.registry import FORMATS
from seamark.server.app import create_app
from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.record.states import RunState
from seamark.sim import registry
from seamark.sim.recording.telemetry import WIDTH
from tests.cast import Backend
from tests.server.pages.conftest import Site
from tests.services import valkey

HOSTILE = "<script>alert(1)</script><img src=x onerror=alert(2)>'\"&"


def _page(site: Site, run_id: int, role: str = "ann") -> str:
    return site.browser(role).get(f"/runs/{run_id}").text


def test_a_queued_run_shows_its_position_and_why_it_waits(site: Site) -> None:
    site.queue("ben")
    run_id = site.queue("ann")

    page = _page(site, run_id)

    assert "This run is number 2 in the queue." in page
    assert "No worker is running" in page
    assert "Cancel" in page


def test_a_run_that_succeeded_shows_score_metrics_and_digest(site: Site) -> None:
    claim = site.running("ann")
    levels = [{"level": 0, "speed": 0.1, "rmse_m": 0.0123, "points": 95.3, "held": True}]
    metrics = {"score": 95.3, "score_low": None, "score_high": None, "level_held": 0.1}
    assert site.finish(claim, metrics=metrics | {"levels": levels, "trials": []})

    page = _page(site, claim.run_id)

    assert "95.30" in page
    assert "RMSE of the distance" in page
    assert "0.0123" in page
    assert "0" * 64 in page


def test_a_failed_run_shows_cause_remedy_traceback_log_and_time(site: Site) -> None:
    detail: dict[str, Any] = {
        "title": "The program raised an error",
        "sentence": "It divided by zero.",
        "remedy": "Check the divisor.",
        "traceback": 'File "mine.py", line 3, in step\nZeroDivisionError',
        "log_tail": "last words",
        "t_reached": 63.0,
    }
    run_id = site.failed(detail)

    page = _page(site, run_id)

    expected = (*list(detail.values())[:3], "ZeroDivisionError", "last words", "1 min 3 s")
    assert [text for text in ("user_error", *expected) if text not in page] == []


def test_hostile_names_logs_and_tracebacks_are_escaped(site: Site) -> None:
    claim = site.running("ann", title=HOSTILE)
    run_id = claim.run_id
    RunFiles(site.settings.data, run_id, claim.attempt).append_log(HOSTILE.encode())
    detail = dict.fromkeys(("title", "sentence", "remedy", "traceback", "log_tail"), HOSTILE)
    failure: dict[str, Any] = {"state": RunState.FAILED, "cause": "user_error", "metrics": None}
    assert site.finish(claim, **failure, detail=detail | {"t_reached": 1.0})
    site.publish(run_id)

    pages = [_page(site, run_id), _page(site, run_id, "ben")]
    pages += [site.browser("ann").get(path).text for path in ("/runs/", "/")]

    assert all("<script>alert" not in page and "<img src=x" not in page for page in pages)
    assert pages[0].count("&lt;script&gt;alert(1)") >= 6


def test_the_data_for_scripts_cannot_break_out_of_its_element(site: Site) -> None:
    run_id = site.queue("ann", title="</script><script>alert(1)</script>")

    page = _page(site, run_id)

    data = re.search(r'id="run-data">(.*?)</script>', page, re.DOTALL)
    assert data is not None
    assert json.loads(data.group(1))["id"] == run_id
    assert "</script><script>alert" not in page


def test_cancelling_a_queued_run_ends_it_and_notifies_open_pages(
    site: Site, redis_url: str
) -> None:
    run_id = site.queue("ann")

    with valkey.listening(redis_url) as listener:
        site.browser("ann").post(f"/runs/{run_id}/cancel")
        told = [(about, values["state"]) for about, values in listener.states()]

    assert site.show(run_id).state is RunState.CANCELLED
    assert told == [(run_id, "cancelled")]


def test_publishing_shows_the_run_to_everybody_and_withdrawing_hides_it(site: Site) -> None:
    run_id = site.succeeded("ann")
    owner, other = site.browser("ann"), site.browser("ben")

    seen = [other.get(f"/runs/{run_id}").status_code]
    for action in ("publish", "withdraw"):
        owner.post(f"/runs/{run_id}/{action}")
        seen.append(other.get(f"/runs/{run_id}").status_code)

    assert seen == [404, 200, 404]


def test_an_owner_deletes_the_data_of_a_run_on_its_page(site: Site) -> None:
    run_id = site.succeeded("ann")
    RunFiles(site.settings.data, run_id, 1).append_rows(np.zeros((3, WIDTH)))
    browser = site.browser("ann")
    before = browser.get(f"/runs/{run_id}").text

    answer = browser.post(f"/runs/{run_id}/delete-data", follow_redirects=True)

    assert f'action="/runs/{run_id}/delete-data"' in before
    assert "The data of the run has been deleted." in answer.text
    assert f'action="/runs/{run_id}/delete-data"' not in answer.text
    assert not RunFiles(site.settings.data, run_id).root.exists()


@pytest.mark.parametrize("state", ["running", "cancelled"])
def test_the_data_so_far_can_be_downloaded_in_every_state(site: Site, state: str) -> None:
    claim = site.running("ann")
    run_id = claim.run_id
    RunFiles(site.settings.data, run_id, claim.attempt).append_rows(np.zeros((3, WIDTH)))
    if state == "cancelled":
        site.browser("ann").post(f"/runs/{run_id}/cancel")

    page = _page(site, run_id)

    assert site.show(run_id).state == state
    assert f'href="/api/v1/runs/{run_id}/telemetry.csv"' in page
    assert site.browser("ann").get(f"/api/v1/runs/{run_id}/telemetry.csv").status_code == 200


def test_a_run_that_is_too_long_for_a_mat_file_offers_none_and_says_why(
    site: Site, monkeypatch: pytest.MonkeyPatch
) -> None:
    run_id = site.succeeded()
    RunFiles(site.settings.data, run_id, 1).append_rows(np.zeros((3, WIDTH)))
    offered = _page(site, run_id)
    monkeypatch.setitem(FORMATS, "mat", replace(FORMATS["mat"], rows_max=2))

    refused = _page(site, run_id)

    assert f"/api/v1/runs/{run_id}/telemetry.mat" in offered
    assert "There is no MAT-file" not in offered
    assert f"/api/v1/runs/{run_id}/telemetry.mat" not in refused
    assert "There is no MAT-file: The run has 3 rows; a MAT-file may have 2." in refused


def test_page_and_api_publish_the_same_when_a_run_is_cancelled(site: Site, redis_url: str) -> None:
    by_page, by_api = site.queue("ann"), site.queue("ann")

    browser = site.browser("ann")
    with valkey.listening(redis_url) as listener:
        browser.post(f"/runs/{by_page}/cancel")
        browser.client.post(
            f"/api/v1/runs/{by_api}/cancel", headers={"X-CSRFToken": browser.csrf_token()}
        )
        (page, page_values), (api, api_values) = listener.states()

    assert (page, api) == (by_page, by_api)
    assert page_values == api_values


def _two_parts(gap: dict[str, float | None]) -> dict[str, Any]:
    """Metrics of a ranked run on reference and fresh trials."""
    return {
        "score": 0.5,
        "score_low": 0.45,
        "score_high": 0.55,
        "reference": {"score": 0.92, "score_low": 0.9, "score_high": 0.94},
        "gap": gap,
        "trials": [
            {"trial": 0, "score": 0.92, "level_held": 0.1, "part": "reference", "levels": []},
            {"trial": 1, "score": 0.5, "level_held": 0.1, "part": "fresh", "levels": []},
        ],
        "levels": [{"level": 0, "speed": 0.1}],
    }


@pytest.mark.slow
@pytest.mark.parametrize(
    ("gap", "sentence"),
    [
        ({"value": 0.42, "low": 0.3, "high": 0.54}, "lies above 0"),
        ({"value": 0.42, "low": -0.1, "high": 0.94}, "contains 0"),
        ({"value": -0.42, "low": -0.5, "high": -0.34}, "lies below 0"),
    ],
)
def test_a_run_on_fresh_water_shows_its_parts_and_what_the_gap_says(
    site: Site, gap: dict[str, float | None], sentence: str
) -> None:
    claim = site.running("ann", kind="ranked", benchmark="currents-v2")
    assert site.finish(claim, metrics=_two_parts(gap))

    page = _page(site, claim.run_id)

    assert "0.920" in page
    assert "0.900 to 0.940" in page
    assert f"{gap['low']:.3f} to".replace("-", "−") in page
    assert sentence in page
    nothing, oracle = registry.benchmark("currents-v2").scale or (math.nan, math.nan)
    assert f"{100 * (0.5 - nothing) / (oracle - nothing):.0f} <small>%</small>" in page
    assert [part in page for part in (">reference</span>", ">fresh</span>")] == [True, True]


def test_a_run_without_two_parts_does_not_mention_them(site: Site) -> None:
    page = _page(site, site.succeeded("ann", kind="ranked"))

    assert "Generalisation gap" not in page


def test_a_run_that_does_not_rank_shows_why(site: Site) -> None:
    claim = site.running("ann", kind="ranked")
    metrics = {"score": 1.0, "rankable": False, "not_ranked": "Trial 9: It drove <away>."}
    assert site.finish(claim, metrics=metrics)

    assert "not ranked. Trial 9: It drove &lt;away&gt;." in _page(site, claim.run_id)


@pytest.mark.parametrize(
    ("origins", "allowed"),
    [("", "'self'"), ("https://a.org http://b:80", "'self' https://a.org http://b:80")],
)
def test_only_the_embedded_player_can_be_shown_in_a_frame_and_only_by_allowed_sites(
    backend: Backend, origins: str, allowed: str
) -> None:
    settings = backend.settings.model_copy(update={"embed_origins": origins})
    app = create_app(settings)
    run_id = backend.succeeded()
    backend.publish(run_id)

    policies = [
        app.test_client().get(f"/runs/{run_id}{path}").headers["Content-Security-Policy"]
        for path in ("/embed", "")
    ]
    app.extensions["seamark"].close()

    assert [policy.rpartition("frame-ancestors ")[2] for policy in policies] == [allowed, "'none'"]
    assert all("script-src 'self'" in policy for policy in policies)
