"""Form entries survive signing up and a refused submission."""

import pytest
from playwright.sync_api import expect

from tests.journey.visitor import Visitor, customise

pytestmark = [pytest.mark.browser, pytest.mark.host, pytest.mark.slow]


def test_form_entries_are_restored_after_signing_up(reader: Visitor) -> None:
    page = reader.page
    reader.open("/submit/visibility-v1")
    customise(page)
    page.get_by_label("Run title").fill("mine")
    page.locator("#seed").fill("42")

    page.locator("main").get_by_role("link", name="create one").click()
    reader.fill_in_account("keeper")

    expect(page.get_by_text("Your previous input has been restored")).to_be_visible()
    expect(page.get_by_label("Run title")).to_have_value("mine")
    expect(page.locator("#seed")).to_have_value("42")
    page.get_by_role("button", name="Discard").click()
    expect(page.locator("#seed")).to_have_value("")
    assert (reader.errors, reader.violations()) == ([], [])


def test_the_form_is_empty_after_an_accepted_run_and_restored_after_a_refused_one(
    reader: Visitor,
) -> None:
    page = reader.page
    reader.open("/submit/currents-v1")
    customise(page)
    page.locator("#seed").fill("7")
    token = page.locator("#run-form input[name=csrf_token]")
    token.evaluate("input => { input.value = 'expired'; }")
    page.get_by_role("button", name="Start run").click()
    page.get_by_role("link", name="Back to the form").click()
    expect(page.locator("#seed")).to_have_value("7")

    customise(page, "Experiment")
    page.get_by_label("Current levels").fill("0")
    page.get_by_label("Level duration").fill("4")
    page.get_by_label("Settle window").fill("1")
    page.get_by_role("button", name="Start run").click()
    page.wait_for_url("**/runs/*")
    page.get_by_role("link", name="New run").first.click()

    expect(page.locator("#seed")).to_have_value("")
    assert reader.violations() == []
