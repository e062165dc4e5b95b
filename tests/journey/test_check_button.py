"""The check button of the editor."""

import pytest
from playwright.sync_api import Page, expect

from tests.journey.visitor import PROGRAM, RUN_MS, Visitor, write_program

pytestmark = [pytest.mark.browser, pytest.mark.host, pytest.mark.slow]


def _write(visitor: Visitor, text: str) -> Page:
    """Open the editor and put a program into it."""
    page = visitor.page
    visitor.open("/submit/currents-v1")
    write_program(page, text)
    return page


def test_the_check_button_appears_with_a_program_and_reports_that_it_runs(reader: Visitor) -> None:
    reader.sign_up("checker")
    reader.open("/submit/currents-v1")
    expect(reader.page.get_by_role("button", name="Check program")).to_be_hidden()

    page = _write(reader, PROGRAM)
    page.get_by_role("button", name="Check program").click()

    expect(page.locator("#check-report")).to_contain_text("The program runs.", timeout=RUN_MS)
    expect(page.locator("#check-report .notice.good")).to_be_visible()
    assert (reader.errors, reader.violations()) == ([], [])


def test_the_line_of_an_error_is_marked_and_a_click_selects_it(
    reader: Visitor,
) -> None:
    reader.sign_up("careless")
    wrong = PROGRAM.replace("x, y, _ = observation.error", "x, y, _ = observation.eror")
    line = next(at for at, text in enumerate(wrong.splitlines(), 1) if "eror" in text)

    page = _write(reader, wrong)
    page.get_by_role("button", name="Check program").click()
    link = page.locator("#check-report").get_by_role("button", name=f"line {line}")
    expect(link).to_be_visible(timeout=RUN_MS)
    link.click()

    assert page.evaluate("getSelection().toString()") == wrong.splitlines()[line - 1]
    expect(page.locator(".cm-problem")).to_have_text(wrong.splitlines()[line - 1])
    expect(page.locator("#check-report .notice.bad")).to_be_visible()
    assert (reader.errors, reader.violations()) == ([], [])
