"""The list of runs in a browser: selecting, comparing and deleting, by keyboard and on a phone."""

import re
from itertools import pairwise

import pytest
from playwright.sync_api import expect

from tests.journey.visitor import Visitor

pytestmark = [pytest.mark.browser, pytest.mark.host, pytest.mark.slow]

SHORT = {"levels": [0.0, 0.1], "level_duration_s": 4, "settle_s": 1}


def _start(visitor: Visitor, title: str) -> None:
    run = {"benchmark": "currents-v2", "controller": "p", "config": SHORT, "title": title}
    response = visitor.page.request.post(f"{visitor.url}/api/v1/runs", data=run)
    visitor.open(f"/runs/{response.json()['id']}")
    visitor.wait_for("succeeded")


def test_runs_are_found_selected_and_deleted_on_a_phone_without_a_mouse(phone: Visitor) -> None:
    page = phone.page
    for title in ("keep this", "drop this", "drop that"):
        _start(phone, title)
    phone.open("/runs/")
    expect(page.locator("svg.sparkline")).to_have_count(3)
    expect(page.get_by_role("button", name="Delete")).to_be_disabled()

    page.get_by_label("Search").focus()
    page.keyboard.type("drop")
    page.keyboard.press("Enter")
    expect(page).to_have_url(re.compile(r"[?&]q=drop"))
    page.get_by_label("Select all").focus()
    page.keyboard.press("Space")
    expect(page.get_by_text("2 selected")).to_be_visible()
    page.get_by_role("button", name="Delete").focus()
    page.keyboard.press("Enter")
    expect(page.get_by_role("dialog")).to_contain_text("Delete the selected runs")
    expect(page.get_by_role("button", name="Go back")).to_be_focused()
    page.keyboard.press("Escape")
    expect(page.get_by_role("dialog")).to_have_count(0)
    expect(page.get_by_label("Select all")).to_be_checked()
    phone.press_and_confirm("Delete")

    expect(page.get_by_text("2 runs were deleted.")).to_be_visible()
    phone.open("/runs/")
    expect(page.get_by_role("checkbox", name="Select run")).to_have_count(1)
    expect(page.get_by_text("keep this")).to_be_visible()
    assert page.evaluate("document.documentElement.scrollWidth") <= 375
    assert (phone.errors, phone.violations()) == ([], [])


def test_the_time_left_counts_down_and_is_written_without_sixty_seconds(visitor: Visitor) -> None:
    visitor.open("/")

    found = visitor.page.evaluate("""async () => {
      const { about, duration, Estimate } = await import("/static/js/run/estimate.js");
      const estimate = new Estimate(100);
      const left = [];
      // Twice as slow as expected at first, then in one leap to where it should be.
      for (let t = 0; t <= 60; t += 1) left.push(estimate.update(t < 30 ? t / 200 : t / 100, t));
      return { texts: [599.7, 59.7, 3599.9].map(duration), about: about(61), left };
    }""")

    left = found["left"]
    steps = [after - before for before, after in pairwise(left)]
    assert found["texts"] == ["10 min", "1 min", "1 h"]
    assert found["about"] == "1 min"
    assert max(abs(step) for step in steps) < 6
    assert visitor.errors == []
