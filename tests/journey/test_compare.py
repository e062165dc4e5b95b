"""Runs side by side in a browser: from a list to one address, by keyboard, on a phone."""

import re
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, Response, expect

from tests.journey.service import Service
from tests.journey.visitor import Visitor

pytestmark = [pytest.mark.browser, pytest.mark.host, pytest.mark.slow]

OWNER = "compares"
SHORT = {"levels": [0.0, 0.3], "level_duration_s": 6, "settle_s": 1}


@pytest.fixture(scope="module")
def run_ids(chromium: Browser, service: Service) -> list[int]:
    """Five public runs of P and PI in turn, which have ended."""
    context = chromium.new_context()
    visitor = Visitor(context.new_page(), service.url)
    visitor.sign_up(OWNER)
    request, api = context.request, f"{service.url}/api/v1"
    headers = {"X-CSRFToken": request.get(f"{api}/me").json()["csrf_token"]}
    runs = []
    for index in range(5):
        controller, config = ("p", "pi")[index % 2], SHORT | {"kp": 0.4 + 0.1 * index}
        run = {"benchmark": "currents-v1", "controller": controller, "config": config, "seed": 3}
        runs.append(request.post(f"{api}/runs", data=run, headers=headers).json()["id"])
    for run_id in runs:
        visitor.wait_elsewhere(run_id)
        assert request.post(f"{api}/runs/{run_id}/publish", headers=headers).ok
    context.close()
    return runs


def _views(page: Page, run_ids: list[int]) -> list[str | None]:
    """Return the addresses of the camera images that are shown."""
    found = []
    for run_id in run_ids:
        image = page.locator(f'[data-view="{run_id}"] img')
        expect(image).to_be_visible(timeout=60_000)
        found.append(image.get_attribute("src"))
    return found


def _expect_time(page: Page, run_ids: list[int], seconds: float) -> None:
    for run_id in run_ids:
        image = page.locator(f'[data-view="{run_id}"] img')
        expect(image).to_have_attribute("src", re.compile(f"t={seconds:.2f}$"))


def test_two_runs_of_the_list_are_compared_and_the_address_shows_the_same(
    reader: Visitor, run_ids: list[int]
) -> None:
    page, run_ids = reader.page, run_ids[:2]
    reader.sign_in(OWNER)
    reader.open("/runs/")
    for run_id in run_ids:
        page.get_by_label(f"Select run {run_id}", exact=True).check()
    page.get_by_role("button", name="Compare").click()
    expect(page.get_by_role("heading", name="Compare 2 runs")).to_be_visible()
    _views(page, run_ids)

    page.locator("select[data-level]").select_option(label="0.3 m/s")
    _expect_time(page, run_ids, 6.0)
    page.get_by_label("Simulated time of all runs").fill("2.5")
    _expect_time(page, run_ids, 8.5)
    page.wait_for_url(re.compile(r"t=2\.50"))
    page.reload()
    _expect_time(page, run_ids, 8.5)

    expect(page.locator("select[data-level]")).to_have_value("1")
    expect(page.locator("[data-charts] .chart")).to_have_count(3)
    expect(page.locator(".readout").first).to_contain_text("2.5 s")
    assert (reader.errors, reader.violations()) == ([], [])


def test_the_scene_has_the_vehicle_and_the_path_of_every_run(
    visitor: Visitor, run_ids: list[int]
) -> None:
    page, run_ids = visitor.page, run_ids[:3]
    fetched: list[str] = []

    def note(response: Response) -> None:
        fetched.append(response.url)

    page.on("response", note)
    visitor.open(f"/compare?runs={','.join(map(str, run_ids))}")

    expect(page.locator("[data-stage][data-pictures]")).to_be_visible(timeout=60_000)
    names = page.get_by_role("list", name="Vehicles in the scene").get_by_role("listitem")
    expect(names).to_have_text([re.compile(f"^#{run_id} ") for run_id in run_ids])
    for part in ("scene.json", "series.json"):
        assert all(any(f"/runs/{run_id}/{part}" in url for url in fetched) for run_id in run_ids)
    page.remove_listener("response", note)
    assert (visitor.errors, visitor.violations()) == ([], [])


def test_five_runs_play_together_by_keyboard_alone(reader: Visitor, run_ids: list[int]) -> None:
    page = reader.page
    reader.open(f"/compare?runs={','.join(map(str, run_ids))}")
    before = _views(page, run_ids)

    page.get_by_role("button", name="Play").focus()
    page.keyboard.press("Enter")
    expect(page.locator("[data-clock]")).to_contain_text(re.compile(r"^[2-9]\.\d+ s"))
    page.keyboard.press("Enter")
    expect(page.get_by_role("button", name="Play")).to_be_visible()
    page.keyboard.press("Tab")
    page.keyboard.press("End")
    expect(page.locator("[data-clock]")).to_contain_text("11.95 s")
    _expect_time(page, run_ids, 11.95)

    assert len(set(_views(page, run_ids))) == 5
    assert set(_views(page, run_ids)).isdisjoint(before)
    assert (reader.errors, reader.violations()) == ([], [])


def test_charts_are_chosen_and_a_run_is_removed(reader: Visitor, run_ids: list[int]) -> None:
    page, run_ids = reader.page, run_ids[:3]
    reader.open(f"/compare?runs={','.join(map(str, run_ids))}")
    expect(page.locator("[data-charts] .chart")).to_have_count(3)

    page.get_by_text("Choose charts").click()
    page.get_by_label("Depth [m]").check()
    expect(page.locator("[data-charts] .chart")).to_have_count(4)
    page.wait_for_url(re.compile(r"columns=[a-z_,]*z"))
    page.get_by_label(f"Remove run {run_ids[0]}").click()

    expect(page.get_by_role("heading", name="Compare 2 runs")).to_be_visible()
    assert f"runs={run_ids[1]},{run_ids[2]}" in page.url
    assert (reader.errors, reader.violations()) == ([], [])


def test_a_comparison_fits_on_a_phone(phone: Visitor, run_ids: list[int]) -> None:
    page = phone.page
    phone.open(f"/compare?runs={','.join(map(str, run_ids))}")
    _views(page, run_ids)

    whole = page.evaluate("document.documentElement.scrollWidth")
    bar: Any = page.get_by_role("group", name="Playback of all runs").bounding_box()

    assert whole <= 375
    assert 0 <= bar["x"] < bar["x"] + bar["width"] <= 375
    assert (phone.errors, phone.violations()) == ([], [])
