"""A vehicle with an arm, seen on the page of its run."""

import re

import pytest
from playwright.sync_api import expect

from tests.journey.visitor import Visitor

pytestmark = [pytest.mark.browser, pytest.mark.host, pytest.mark.slow]
WITH_ARM = {
    "arm": "alpha-like",
    "vehicle": "bluerov2-heavy-v2",
    "levels": [0.1],
    "level_duration_s": 4.0,
    "settle_s": 1.0,
}


def test_an_arm_stands_in_the_scene_its_camera_can_be_chosen_and_its_joints_charted(
    visitor: Visitor,
) -> None:
    visitor.sign_up("reaching")
    run = {"benchmark": "currents-v2", "controller": "pi", "config": WITH_ARM}
    number = visitor.submit(run)
    visitor.wait_elsewhere(number)
    visitor.open(f"/runs/{number}")
    page = visitor.page

    expect(page.locator(".legend .wrist")).to_have_text("force at the wrist")
    shown = page.locator("[data-camera] img")
    expect(shown).to_have_attribute("src", re.compile(r"camera\.jpg"))
    page.get_by_label("On the arm").check()
    expect(shown).to_have_attribute("src", re.compile("camera=arm"))
    assert shown.evaluate("image => [image.naturalWidth, image.naturalHeight]") == [320, 240]
    page.get_by_text("Choose charts").click()
    page.get_by_label("Joints [rad]").check()
    expect(page.get_by_role("img", name=re.compile("Joints"))).to_be_visible()
    assert (visitor.errors, visitor.violations()) == ([], [])
