"""Markup in whatever a user can write is shown as text in a real browser, and never runs."""

import pytest
from playwright.sync_api import Dialog, FilePayload, expect

from tests.journey.visitor import RUN_MS, Visitor, choose_file, shorten

pytestmark = [pytest.mark.browser, pytest.mark.host, pytest.mark.slow]

MARKUP = '<img src=x onerror="window.ran = 1; alert(1)"><script>window.ran = 1</script>'
PROGRAM = f"""
MARKUP = {MARKUP!r}

class Controller:
    def __init__(self, config):
        self.steps = 0
        print(MARKUP)

    def step(self, observation):
        self.steps += 1
        if self.steps == 60:
            raise ValueError(MARKUP)
        return [0.0, 0.0, 0.0, 0.0]
"""


def test_markup_of_a_user_is_shown_as_text_on_every_page(visitor: Visitor) -> None:
    page, dialogs = visitor.page, list[str]()

    def note(dialog: Dialog) -> None:
        dialogs.append(dialog.message)

    page.on("dialog", note)
    visitor.sign_up("scripter")
    visitor.open("/submit/currents-v1")
    name = "<img src=x onerror=alert(1)>.py"
    file = FilePayload(name=name, mimeType="text/x-python", buffer=PROGRAM.encode())
    choose_file(page, file)
    shorten(page)
    page.locator("[name=title]").fill(MARKUP)

    page.get_by_role("button", name="Check program").click()
    expect(page.locator("main")).to_contain_text("onerror=", timeout=RUN_MS)
    found = [page.evaluate("window.ran")]
    page.get_by_role("button", name="Start run").click()
    visitor.wait_for("failed")
    expect(page.locator("main")).to_contain_text("<script>window.ran = 1</script>")
    run = page.url.removeprefix(visitor.url)
    for path in (run, "/runs/", "/", f"/submit/currents-v1?from={run.rsplit('/', 1)[1]}"):
        visitor.open(path)
        found.append(page.evaluate("window.ran"))
        assert visitor.violations() == []

    visitor.open("/runs/")
    expect(page.get_by_role("table")).to_contain_text(name)
    page.remove_listener("dialog", note)
    assert found == [None] * 5
    assert (visitor.errors, dialogs) == ([], [])
