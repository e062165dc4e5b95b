"""The check button of the editor."""

import pytest
from playwright.sync_api import Page, expect

from tests.journey.visitor import PROGRAM, RUN_MS, Visitor

pytestmark = [pytest.mark.browser, pytest.mark.host, pytest.mark.slow]


def _write(visitor: Visitor, text: str) -> Page:
    """Open the editor and put a program into it."""
    page = visitor.page
    visitor.open("/submit/currents-v1")
    page.get_by_text("My own program").click()
    page.get_by_role("radio", name="Editor").check()
    page.get_by_label("Your program").fill(text)
    return page


def test_the_check_button_appears_with_a_program_and_reports_that_it_runs(visitor: Visitor) -> None:
    visitor.sign_up("checker")
    visitor.open("/submit/currents-v1")
    expect(visitor.page.get_by_role("button", name="Check program")).to_be_hidden()

    page = _write(visitor, PROGRAM)
    page.get_by_role("button", name="Check program").click()

    expect(page.locator("#check-report")).to_contain_text("The program runs.", timeout=RUN_MS)
    expect(page.locator("#check-report .notice.good")).to_be_visible()
    assert (visitor.errors, visitor.violations()) == ([], [])


def test_clicking_the_line_of_an_error_selects_it_in_the_editor(visitor: Visitor) -> None:
    visitor.sign_up("careless")
    wrong = PROGRAM.replace("x, y, _ = observation.error", "x, y, _ = observation.eror")
    line = next(at for at, text in enumerate(wrong.splitlines(), 1) if "eror" in text)

    page = _write(visitor, wrong)
    page.get_by_role("button", name="Check program").click()
    link = page.locator("#check-report").get_by_role("button", name=f"line {line}")
    expect(link).to_be_visible(timeout=RUN_MS)
    link.click()

    selected = page.evaluate("""() => {
      const area = document.activeElement;
      return area.value.slice(area.selectionStart, area.selectionEnd);
    }""")
    assert selected == wrong.splitlines()[line - 1]
    expect(page.locator("#check-report .notice.bad")).to_be_visible()
    assert (visitor.errors, visitor.violations()) == ([], [])
