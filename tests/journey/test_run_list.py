"""Publishing and withdrawing a run, and many runs of the list at once, by keyboard."""

import re

import pytest
from playwright.sync_api import expect

from tests.journey.visitor import RUN_MS, Visitor

pytestmark = [pytest.mark.browser, pytest.mark.host, pytest.mark.slow]

SHORT = {"levels": [0.0, 0.1], "level_duration_s": 4, "settle_s": 1}
PROFILE = "/users/publisher"  # there is one for strangers while something is public
RUN = {"benchmark": "currents-v2", "controller": "p", "config": SHORT}


def _reads(visitor: Visitor, path: str) -> int | None:
    """Open a page and return the status of the answer."""
    response = visitor.page.goto(visitor.url + path)
    return None if response is None else response.status


def test_a_stranger_sees_a_run_only_between_its_publication_and_its_withdrawal(
    reader: Visitor, phone: Visitor
) -> None:
    page, stranger = reader.page, phone.page
    reader.sign_up("publisher")
    run = f"/runs/{reader.submit(RUN | {'title': 'Worth reading'})}"
    reader.open(run)
    reader.wait_for("succeeded")
    page.get_by_role("link", name="Publish …").click()
    expect(page.get_by_role("main")).to_contain_text("Everyone will be able to see the results")
    assert reader.violations() == []
    page.get_by_role("link", name="Cancel").click()
    seen = [_reads(phone, run), _reads(phone, PROFILE)]

    reader.publish()
    expect(page.get_by_text("The run is now public")).to_be_visible(timeout=RUN_MS)
    phone.errors.clear()  # the browser reports the 404s of before
    seen.append(_reads(phone, run))
    expect(stranger.get_by_role("heading", name="Steady hand")).to_be_visible()
    expect(stranger.get_by_role("button", name="Withdraw")).to_have_count(0)
    expect(stranger.get_by_role("link", name="telemetry.csv")).to_be_visible()
    seen.append(_reads(phone, PROFILE))
    expect(stranger.get_by_role("table")).to_contain_text("Steady hand")
    assert (phone.errors, phone.violations()) == ([], [])

    reader.press_and_confirm("Withdraw")
    expect(page.get_by_text("The run is private again.")).to_be_visible(timeout=RUN_MS)
    seen += [_reads(phone, run), _reads(phone, PROFILE)]

    assert seen == [404, 404, 200, 200, 404, 404]
    assert (reader.errors, reader.violations()) == ([], [])


def test_runs_are_found_published_withdrawn_and_deleted_by_keyboard_alone(phone: Visitor) -> None:
    page, keyboard = phone.page, phone.page.keyboard
    phone.sign_up("bulk")
    titles = ("keep this", "drop this", "drop that")
    for run_id in [phone.submit(RUN | {"title": title}) for title in titles]:
        phone.wait_elsewhere(run_id)
    phone.open("/runs/")
    expect(page.locator("svg.sparkline")).to_have_count(3)
    phone.tab_to(page.get_by_role("searchbox", name="Search"), most=40)
    keyboard.type("drop")
    keyboard.press("Enter")
    expect(page).to_have_url(re.compile(r"[?&]q=drop"))

    every = page.get_by_label("Select all")
    for name, done in (
        ("Publish", "2 runs were published."),
        ("Make private", "2 runs were made private."),
        ("Delete", "2 runs were deleted."),
    ):
        button = page.get_by_role("button", name=name)
        expect(button).to_be_disabled()
        phone.tab_to(every, most=40)
        keyboard.press("Space")
        expect(page.get_by_text("2 selected")).to_be_visible()
        phone.tab_to(button)
        keyboard.press("Enter")
        expect(page.get_by_role("dialog").get_by_role("button", name="Go back")).to_be_focused()
        keyboard.press("Escape")
        expect(page.get_by_role("dialog")).to_have_count(0)
        expect(button).to_be_focused()
        keyboard.press("Enter")
        phone.tab_to(page.get_by_role("dialog").get_by_role("button", name=name), most=1)
        keyboard.press("Enter")
        expect(page.get_by_text(done)).to_be_visible(timeout=RUN_MS)
    phone.open("/runs/")

    expect(page.get_by_role("checkbox", name="Select run")).to_have_count(1)
    expect(page.get_by_role("table")).to_contain_text("keep this")
    assert page.evaluate("document.documentElement.scrollWidth") <= 375
    assert (phone.errors, phone.violations()) == ([], [])
