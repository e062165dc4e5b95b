"""A detector from its first check to the pictures that teach most."""

import re

import pytest
from playwright.sync_api import Page, expect

from tests.journey import accessibility
from tests.journey.visitor import (
    PHONE_PX,
    RUN_MS,
    Visitor,
    customise,
    width_on_a_phone,
    write_program,
)

pytestmark = [pytest.mark.browser, pytest.mark.host, pytest.mark.slow]
IMAGES = 5  # of a check
DETECTOR = """
class Detector:
    def __init__(self, config):
        self.seen = 0

    def detect(self, image):
        self.seen += 1
        height, width = image.shape[:2]
        whole = [[0, 0], [width, 0], [width, height], [0, height]]
        return [("box", whole, 0.7), ("pipe", [[10, 10], [90, 10], [90, 60], [10, 60]], 0.4)]
"""


def test_a_detector_is_checked_and_run_and_its_mistakes_are_seen(reader: Visitor) -> None:
    page = reader.page
    reader.sign_up("seer")
    reader.open("/submit/patterns-v1")
    write_program(page, DETECTOR)

    _check(page)
    _start_short_run(page)
    reader.wait_for("succeeded")
    _hide_and_show_answers(page)
    _see_curves(page)
    _follow_an_example(page)

    assert list(accessibility.defects(page)) == []
    assert width_on_a_phone(page) <= PHONE_PX
    assert (reader.errors, reader.violations()) == ([], [])


def _check(page: Page) -> None:
    page.get_by_role("button", name="Check program").click()
    expect(page.locator("#check-report")).to_contain_text("The program runs.", timeout=RUN_MS)
    images = page.locator(".check-images img")
    expect(images).to_have_count(IMAGES)
    for image in images.all():
        image.scroll_into_view_if_needed()
        _expect_loaded(page, image.get_attribute("src") or "")


def _expect_loaded(page: Page, address: str) -> None:
    answer = page.request.get(page.url.partition("/submit")[0] + address)
    expect(answer).to_be_ok()
    assert answer.headers["content-type"] == "image/jpeg"


def _start_short_run(page: Page) -> None:
    customise(page, "Levels")
    page.get_by_label("Optical depths").fill("0, 6")
    page.get_by_label("Level duration").fill("3")
    page.get_by_role("button", name="Start run").click()
    page.wait_for_url(re.compile(r"/runs/\d+"))


def _hide_and_show_answers(page: Page) -> None:
    image = page.locator("[data-camera] img")
    expect(image).to_be_visible(timeout=RUN_MS)
    page.get_by_role("checkbox", name="Answers").uncheck()
    expect(image).to_have_attribute("src", re.compile("tracked=false"))
    page.get_by_role("checkbox", name="Answers").check()
    expect(image).not_to_have_attribute("src", re.compile("tracked=false"))
    expect(page.get_by_label("Zoom to target")).to_have_count(0)


def _see_curves(page: Page) -> None:
    page.locator("[data-recognition]").scroll_into_view_if_needed()
    expect(page.get_by_role("img", name="Precision over recall")).to_be_visible()
    lines = page.get_by_label("Average precision at each optical depth").locator("li")
    expect(lines).to_have_text([re.compile(r"^0: .* %"), re.compile(r"^6: .* %")])
    confusion = page.get_by_role("region", name="What answers lie on").locator("table")
    expect(confusion.locator("tfoot tr")).to_have_count(2)


def _follow_an_example(page: Page) -> None:
    alarm = page.locator(".gallery a").first
    expect(alarm).to_contain_text(re.compile(r"box 0\.70 on"))
    address = alarm.get_attribute("href") or ""
    t = float(re.findall(r"t=([\d.]+)", address)[0])
    alarm.click()
    expect(page.locator("[data-clock]")).to_contain_text(f"{t:.2f} s")
