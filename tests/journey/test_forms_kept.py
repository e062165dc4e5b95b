"""What somebody has typed is not lost on the way to an account."""

import pytest
from playwright.sync_api import expect

from tests.journey.visitor import Visitor

pytestmark = [pytest.mark.browser, pytest.mark.host, pytest.mark.slow]


def test_signing_up_from_the_form_brings_its_entries_back(visitor: Visitor) -> None:
    page = visitor.page
    visitor.open("/submit/visibility-v1")
    page.get_by_label("Name of the run").fill("mine")
    page.locator("#seed").fill("42")

    page.locator("main").get_by_role("link", name="sign up").first.click()
    visitor.fill_in_account("keeper")

    expect(page.get_by_text("What you had entered is here again")).to_be_visible()
    expect(page.get_by_label("Name of the run")).to_have_value("mine")
    expect(page.locator("#seed")).to_have_value("42")
    page.get_by_role("button", name="Start afresh").click()
    expect(page.locator("#seed")).to_have_value("")
    assert (visitor.wrong, visitor.violations()) == ([], [])


def test_a_form_that_was_sent_begins_empty_again_unless_it_was_refused(visitor: Visitor) -> None:
    page = visitor.page
    visitor.open("/submit/currents-v1")
    page.locator("#seed").fill("7")
    secret = page.locator("#run-form input[name=csrf_token]")
    secret.evaluate("input => { input.value = 'of another time'; }")
    page.get_by_role("button", name="Start the run").click()
    page.get_by_role("link", name="Back to the form").click()
    expect(page.locator("#seed")).to_have_value("7")

    page.get_by_label("Current levels").fill("0")
    page.get_by_label("Length of a level").fill("4")
    page.get_by_label("Settle window").fill("1")
    page.get_by_role("button", name="Start the run").click()
    page.wait_for_url("**/runs/*")
    page.get_by_role("link", name="New run").first.click()

    expect(page.locator("#seed")).to_have_value("")
    assert visitor.violations() == []
