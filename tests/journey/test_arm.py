"""A vehicle with an arm, and what it works on, seen on the page of its run."""

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


RECOVER = {
    "benchmark": "recover-v1",
    "controller": "scripted",
    "seed": 2026,
    "config": {"levels": [0.0], "level_duration_s": 26.0},
}


def test_stages_are_bands_of_the_time_line_and_the_box_rises_with_the_hand(
    visitor: Visitor,
) -> None:
    visitor.sign_up("recovering")
    number = visitor.submit(RECOVER)
    visitor.wait_elsewhere(number)
    page = visitor.page
    page.set_viewport_size({"width": 390, "height": 844})

    visitor.open(f"/runs/{number}#t=21")

    bands = page.locator("[data-stages] i")
    expect(bands.first).to_be_attached()
    labels = page.locator("[data-stage-legend] li")
    expect(labels).to_have_count(5)
    third = page.locator('[data-stages] [data-stage="2"]')
    third.click()
    expect(page.locator(".stage-note")).to_contain_text("Taken off the seabed")
    expect(page.locator("[data-numbers]")).to_contain_text("StageTaken off the seabed")
    expect(page.locator('[data-label="push"]')).to_have_text(re.compile(r"^\d+ N$"))
    assert (visitor.errors, visitor.violations()) == ([], [])
