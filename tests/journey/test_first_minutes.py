"""The first minutes of a newcomer: something moves at once, and five lines become a run."""

import re

import pytest
from playwright.sync_api import Locator, expect

from tests.journey.visitor import RUN_MS, Visitor

pytestmark = [pytest.mark.browser, pytest.mark.host, pytest.mark.slow]

LIVE = re.compile("Show its page|Watch it live|Show its result")
DRAWN = re.compile(r"[1-9]\d*")


def _is_drawn_on_and_on(stage: Locator) -> None:
    expect(stage).to_have_attribute("data-pictures", DRAWN, timeout=RUN_MS)
    before = stage.get_attribute("data-pictures") or ""
    expect(stage).not_to_have_attribute("data-pictures", before, timeout=RUN_MS)


def test_the_demo_plays_while_the_same_run_waits_or_runs_and_leads_to_it(visitor: Visitor) -> None:
    page = visitor.page
    visitor.open("/")
    expect(page.locator("img.poster")).to_have_js_property("complete", True)
    # The processor draws here, so the replay waits until it is asked to go on.
    expect(page.locator("[data-stage]")).to_have_attribute("data-pictures", DRAWN, timeout=RUN_MS)
    page.get_by_role("button", name="Play").click()
    _is_drawn_on_and_on(page.locator("[data-stage]"))

    page.get_by_role("button", name="Watch a demo").click()

    expect(page.get_by_text("This is a recorded run")).to_be_visible()
    _is_drawn_on_and_on(page.locator("[data-stage]"))
    expect(page.locator("[data-camera] img")).to_be_visible()
    # On a machine that has just started the live run waits while the recorded one plays.
    page.get_by_role("link", name=LIVE).click()
    page.wait_for_url("**/runs/*")
    assert (visitor.errors, visitor.violations()) == ([], [])


def test_the_first_controller_is_kept_over_signing_up_and_runs(reader: Visitor) -> None:
    page = reader.page
    reader.open("/")
    page.get_by_role("link", name="Write your first controller").click()
    page.locator(".cm-content").click()
    page.keyboard.press("Control+End")
    page.keyboard.type("# mine")

    page.get_by_role("link", name="Create an account to run it").click()
    reader.fill_in_account("first-timer")

    expect(page.locator(".cm-content")).to_contain_text("# mine")
    page.get_by_role("button", name="Run it").click()
    page.wait_for_url("**/runs/*")
    reader.wait_for("succeeded")
    assert (reader.errors, reader.violations()) == ([], [])


def test_the_guide_of_the_first_controller_is_below_the_editor_on_a_phone(phone: Visitor) -> None:
    page = phone.page
    phone.open("/first-controller")

    editor = page.locator(".editor").bounding_box()
    guide = page.get_by_role("heading", name="How it works").bounding_box()

    assert editor is not None
    assert guide is not None
    assert guide["y"] > editor["y"] + editor["height"]
    assert page.evaluate("document.documentElement.scrollWidth") == 375
