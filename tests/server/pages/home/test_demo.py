"""The demo: a recorded run at once, and the same run live behind it."""

import json
import re
from urllib.parse import urlsplit

import cv2
import numpy as np

from seamark.server.runs.showing import recorded_demo
from tests.server.pages.conftest import Browser, Site

_DATA = re.compile(r'<script type="application/json" id="run-data">(.*?)</script>', re.DOTALL)


def _live(browser: Browser) -> int:
    started = browser.post("/demo")
    assert started.status_code == 303
    path, query = urlsplit(started.location)[2:4]
    assert path == "/demo"
    return int(query.removeprefix("run="))


def test_the_demo_plays_without_worker_camera_and_account(site: Site) -> None:
    stranger = site.browser()

    page = stranger.get("/demo").text

    found = _DATA.search(page)
    assert found is not None
    data = json.loads(found.group(1))
    assert "recorded run" in page
    assert data["live"] is False
    columns = ",".join(column["name"] for column in data["columns"])
    series = stranger.get(f"{data['api']}/series.json?columns={columns}&sample=rows").get_json()
    assert series["rows"] == 1200
    assert stranger.get(f"{data['api']}/moments.json").get_json()["largest_error"]["value"] > 1.0
    for picture in ("camera.jpg?t=47.3", "texture.jpg?part=seabed", "texture.jpg?part=target"):
        jpeg = stranger.get(f"{data['api']}/{picture}").data
        assert cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR) is not None
    assert stranger.get(f"{data['api']}/scene.json?level=2").get_json()["vehicle"]["hull"]


def test_watching_the_demo_starts_the_same_run_live_for_a_visitor(site: Site) -> None:
    browser = site.browser()

    run_id = _live(browser)

    shown = browser.get(f"/demo?run={run_id}").text
    assert "is waiting" in shown
    assert "data-live" in shown
    assert f'href="/runs/{run_id}"' in shown
    assert site.browser().get(f"/runs/{run_id}").status_code == 404  # it is the visitor's own


def test_the_page_of_the_demo_offers_the_live_run_when_it_has_started(site: Site) -> None:
    browser = site.browser()
    run_id = _live(browser)
    site.claim_next()

    shown = browser.get(f"/demo?run={run_id}").text

    assert "has started" in shown
    assert ">Watch it live</a>" in shown


def test_a_live_run_with_the_same_digest_is_said_to_be_the_same(site: Site) -> None:
    browser = site.browser()
    run_id = _live(browser)
    site.finish(site.claim_next(), digest=recorded_demo.digest())

    shown = browser.get(f"/demo?run={run_id}").text

    assert "bit for bit" in shown
    assert "data-live" not in shown


def test_the_run_of_somebody_else_is_not_mentioned_beside_the_demo(site: Site) -> None:
    run_id = _live(site.browser())

    shown = site.browser("ben").get(f"/demo?run={run_id}")

    assert shown.status_code == 200
    assert f"/runs/{run_id}" not in shown.text
    assert "Run the same live" in shown.text


def test_the_live_run_is_the_recorded_one(site: Site) -> None:
    browser = site.browser()
    run = browser.get(f"/api/v1/runs/{_live(browser)}").get_json()

    recorded = recorded_demo.run()

    assert run["config"] == json.loads(json.dumps(recorded.config))
    assert (run["benchmark"], run["controller"]) == (recorded.benchmark, recorded.controller)
    assert (run["seed"], run["trials"]) == (recorded.seed, recorded.trials)


def test_a_demo_beyond_the_quota_says_so_and_plays_the_recorded_run(site: Site) -> None:
    browser = site.browser()
    for _ in range(site.settings.quota_live):
        _live(browser)

    refused = browser.post("/demo", follow_redirects=True)

    assert refused.request.path == "/demo"
    assert "notice warn" in refused.text
    assert "recorded run" in refused.text
