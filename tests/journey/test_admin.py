"""The administration with the keyboard alone: every area, questions, a rejudgement to its end."""

import re
from collections.abc import Iterator
from contextlib import closing
from typing import Any

import pytest
from playwright.sync_api import Browser, Locator, expect

from seamark.server.accounts import accounts
from seamark.server.accounts.permissions import Role
from seamark.server.database.engine import Database
from tests.journey.conftest import TRACKING
from tests.journey.service import Service
from tests.journey.visitor import PASSWORD, RUN_MS, Visitor

pytestmark = [pytest.mark.browser, pytest.mark.host, pytest.mark.slow]

KEYS_MAX = 80  # of Tab on the way to a control
ADMIN, OTHER = "keyboard-admin", "keyboard-user"


@pytest.fixture
def admin(chromium: Browser, service: Service) -> Iterator[Visitor]:
    with closing(Database(f"sqlite:///{service.data / 'seamark.db'}")) as database:
        with database.writing() as session:
            accounts.sign_up(session, ADMIN, PASSWORD, role=Role.ADMIN)
            accounts.sign_up(session, OTHER, PASSWORD)
    context = chromium.new_context(viewport={"width": 375, "height": 800}, reduced_motion="reduce")
    visitor = Visitor(context.new_page(), service.url)
    visitor.open("/sign-in")
    visitor.page.get_by_label("Name").fill(ADMIN)
    visitor.page.get_by_label("Password").fill(PASSWORD)
    visitor.page.keyboard.press("Enter")
    expect(visitor.page).not_to_have_url(re.compile("/sign-in"))
    visitor.open("/admin/")
    yield visitor
    context.close()


def _press(visitor: Visitor, control: Locator, key: str = "Enter") -> None:
    """Go to a control with the Tab key and press it there."""
    visitor.page.wait_for_load_state("load")
    visitor.tab_to(control, KEYS_MAX)
    visitor.page.keyboard.press(key)


def _button(visitor: Visitor, name: str) -> Locator:
    return visitor.page.get_by_role("main").get_by_role("button", name=re.compile(name))


def _confirm(visitor: Visitor, name: str, key: str = "Enter") -> None:
    """Press a button that asks, say no by Escape, press it again and say yes."""
    button, dialog = _button(visitor, name), visitor.page.get_by_role("dialog")
    _press(visitor, button, key)
    expect(dialog.get_by_role("button", name="Go back")).to_be_focused()
    visitor.page.keyboard.press("Escape")
    expect(dialog).to_have_count(0)
    expect(button).to_be_focused()
    visitor.page.keyboard.press(key)
    expect(dialog.get_by_role("button", name="Go back")).to_be_focused()
    visitor.page.keyboard.press("Tab")
    expect(dialog.get_by_role("button").last).to_be_focused()
    visitor.page.keyboard.press(key)


def _areas(visitor: Visitor) -> list[str]:
    links = visitor.page.get_by_role("navigation", name="Administration").get_by_role("link")
    return links.all_text_contents()


def test_an_admin_reaches_and_does_everything_with_the_keyboard(admin: Visitor) -> None:
    page = admin.page
    # Of a benchmark that hardly any other test here runs, since all its runs are computed again.
    order: Any = {"benchmark": "visibility-v2", "config": TRACKING, "controller": "built-in"}
    run_id = admin.submit(order)
    area = page.get_by_role("navigation", name="Administration")

    for name in _areas(admin):
        _press(admin, area.get_by_role("link", name=name, exact=True))
        expect(page.get_by_role("main").get_by_role("heading", level=1)).to_be_visible()
        expect(page).to_have_title(re.compile("Admin"))

    _press(admin, area.get_by_role("link", name="Workers"))
    _confirm(admin, "Drain")
    _press(admin, _button(admin, "Resume"), "Space")
    expect(_button(admin, "Drain")).to_be_visible()

    admin.open("/admin/users?q=" + OTHER)
    _press(admin, page.get_by_role("link", name=OTHER))
    _confirm(admin, "Disable", "Space")
    expect(page.get_by_text("This account is disabled")).to_be_visible()

    admin.wait_elsewhere(run_id)
    admin.open("/admin/rejudgements")
    _press(admin, page.get_by_role("link", name="New rejudgement"))
    admin.tab_to(page.get_by_label("Benchmark"), KEYS_MAX)
    page.keyboard.type("visibility-v2")
    _press(admin, _button(admin, "Preview"))
    admin.tab_to(page.get_by_label("Reason"), KEYS_MAX)
    page.keyboard.type("To be sure")
    _press(admin, _button(admin, "Compute"))
    expect(page.get_by_role("heading", name="Rejudgement")).to_be_visible()
    expect(page.get_by_text("No result differs")).to_be_visible(timeout=RUN_MS)  # without a reload
    _confirm(admin, "Accept")
    expect(page.get_by_text("Accepted by")).to_be_visible()

    assert admin.errors == []
    assert admin.violations() == []
