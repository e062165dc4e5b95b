"""The first screen of a run's page, its layout, and the player on the whole screen."""

import json
import re
from collections.abc import Iterator
from typing import Any

import pytest
from playwright.sync_api import Browser, FilePayload, Page, expect

from tests.journey.conftest import TRACKING
from tests.journey.service import Service
from tests.journey.visitor import LONG, RUN_MS, Visitor

pytestmark = [pytest.mark.browser, pytest.mark.host, pytest.mark.slow]

SCREEN_PX = 900
BROKEN = """
class Controller:
    def __init__(self, config):
        pass

    def reset(self, level):
        pass

    def step(self, observation):
        return [1.0 / (2.0 - observation.t), 0.0, 0.0, 0.0]
"""
VIEWS = ("[data-stage]", "[data-camera]", "[data-charts] .chart:first-child")


def _bottoms(page: Page) -> dict[str, float]:
    """Return how far down scene, camera and main chart reach, of a page that is not scrolled."""
    expect(page.locator(VIEWS[-1])).to_be_visible()
    boxes = {view: page.locator(view).bounding_box() for view in VIEWS}
    return {view: box["y"] + box["height"] for view, box in boxes.items() if box}


def _assert_first_screen(page: Page) -> None:
    bottoms = _bottoms(page)
    assert len(bottoms) == len(VIEWS)
    assert max(bottoms.values()) <= SCREEN_PX, bottoms
    assert page.evaluate("scrollY") == 0


def _submit_broken(visitor: Visitor) -> int:
    """Queue a run of a program that fails after two seconds, and return its number."""
    request, api = visitor.page.request, f"{visitor.url}/api/v1"
    run = json.dumps({"benchmark": "currents-v1", "config": LONG})
    program: FilePayload = {"name": "b.py", "mimeType": "text/plain", "buffer": BROKEN.encode()}
    response = request.post(
        f"{api}/runs",
        multipart={"run": run, "program": program},
        headers={"X-CSRFToken": request.get(f"{api}/me").json()["csrf_token"]},
    )
    expect(response).to_be_ok()
    number: int = response.json()["id"]
    return number


@pytest.fixture(scope="module")
def _owner(chromium: Browser, service: Service) -> Iterator[Visitor]:
    context = chromium.new_context(viewport={"width": 1280, "height": SCREEN_PX})
    yield Visitor(context.new_page(), service.url)
    context.close()


@pytest.fixture
def owner(_owner: Visitor, finished: tuple[int, Any]) -> Iterator[Visitor]:
    """The owner of the finished run, with a desktop screen."""
    _owner.page.context.add_cookies(finished[1]["cookies"])
    yield _owner
    _owner.leave()


def test_scene_camera_and_main_chart_of_a_finished_run_are_on_the_first_screen(
    visitor: Visitor, owner: Visitor, finished: tuple[int, Any]
) -> None:
    for one in (visitor, owner):
        one.open(f"/runs/{finished[0]}")
        _assert_first_screen(one.page)
        assert (one.errors, one.violations()) == ([], [])


def test_a_tracking_run_has_its_first_screen_from_the_queue_to_the_end(owner: Visitor) -> None:
    run = {"benchmark": "visibility-v2", "controller": "built-in", "config": TRACKING}

    owner.open(f"/runs/{owner.submit(run)}")
    _assert_first_screen(owner.page)
    owner.wait_for("succeeded")

    _assert_first_screen(owner.page)
    assert (owner.errors, owner.violations()) == ([], [])


def test_a_run_that_failed_shows_why_and_still_its_first_screen(owner: Visitor) -> None:
    owner.open(f"/runs/{_submit_broken(owner)}")
    owner.wait_for("failed")

    _assert_first_screen(owner.page)
    expect(owner.page.get_by_text("ZeroDivisionError").first).to_be_in_viewport()


def test_a_run_has_its_first_screen_while_it_runs_and_when_it_is_cancelled(owner: Visitor) -> None:
    run = {"benchmark": "currents-v1", "controller": "p", "config": LONG}
    owner.open(f"/runs/{owner.submit(run)}")
    expect(owner.page.locator("[data-camera] img")).to_be_visible(timeout=RUN_MS)
    _assert_first_screen(owner.page)

    owner.press_and_confirm("Cancel")
    owner.wait_for("cancelled")

    _assert_first_screen(owner.page)  # below the message that it is cancelled
    assert (owner.errors, owner.violations()) == ([], [])


def test_on_a_phone_the_scene_comes_first_and_is_whole_on_the_first_screen(
    phone: Visitor, finished: tuple[int, Any]
) -> None:
    phone.open(f"/runs/{finished[0]}")

    scene, camera, chart = _bottoms(phone.page).values()
    bar = phone.page.locator("[data-bar]").bounding_box()

    assert bar is not None
    assert scene < camera < chart
    assert scene <= bar["y"]
    assert phone.page.evaluate("document.documentElement.scrollWidth") <= 375


def test_the_player_fills_the_screen_by_key_and_by_button_and_escape_leaves(
    visitor: Visitor, finished: tuple[int, Any]
) -> None:
    page = visitor.page
    visitor.open(f"/runs/{finished[0]}")
    button = page.get_by_role("button", name="Full screen")
    expect(button).to_be_visible()

    page.keyboard.press("f")
    leave = page.get_by_role("button", name="Leave full screen")
    expect(leave).to_be_visible()
    expect(page.locator("#metrics-title")).to_be_hidden()
    expect(page.locator("[data-bar]")).to_be_in_viewport(ratio=0.9)
    assert max(_bottoms(page).values()) <= SCREEN_PX
    page.keyboard.press("f")
    expect(button).to_be_visible()
    button.click()
    expect(leave).to_be_visible()
    page.evaluate("document.exitFullscreen()")  # what Escape does in a browser with a window

    expect(button).to_be_visible()
    expect(page.locator("#metrics-title")).to_be_visible()
    assert (visitor.errors, visitor.violations()) == ([], [])


def test_the_layout_is_the_same_after_a_reload_and_on_another_run(
    visitor: Visitor, finished: tuple[int, Any]
) -> None:
    page = visitor.page
    visitor.open(f"/runs/{finished[0]}")
    splitter = page.get_by_role("separator", name="Width of the scene")
    slider = page.locator("[data-time]")
    before = page.locator("[data-camera]").bounding_box()

    splitter.focus()
    page.keyboard.press("Home")
    expect(splitter).to_have_attribute("aria-valuenow", "25")
    expect(slider).to_have_value("0")  # the key moved the splitter, not the playhead
    page.get_by_text("All numbers").click()
    expect(page.get_by_text("Simulated time", exact=True)).to_be_visible()
    page.reload()

    expect(splitter).to_have_attribute("aria-valuenow", "25")
    expect(page.get_by_text("Simulated time", exact=True)).to_be_visible()
    after = page.locator("[data-camera]").bounding_box()
    assert before is not None
    assert after is not None
    assert after["width"] > 1.5 * before["width"]
    assert (visitor.errors, visitor.violations()) == ([], [])


def test_the_menu_of_actions_closes_by_escape_and_by_a_click_elsewhere(
    reader: Visitor, finished: tuple[int, Any]
) -> None:
    page = reader.page
    reader.open(f"/runs/{finished[0]}")
    copy = page.get_by_role("button", name=re.compile("Copy link|Copied|Copy failed"))
    expect(copy).to_be_hidden()

    more = page.locator("[data-part=actions]").get_by_text("More", exact=True)
    more.click()
    expect(copy).to_be_visible()
    page.keyboard.press("Escape")
    expect(copy).to_be_hidden()
    more.click()
    expect(copy).to_be_visible()
    page.locator("h1").click()
    expect(copy).to_be_hidden()
