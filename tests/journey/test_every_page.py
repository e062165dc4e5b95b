"""Every page that a browser can open: accessible, light, as wide as a phone, without errors."""

from collections.abc import Iterator
from typing import Any

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Browser, Page

from performance.requests import create_first, pages
from seamark.server.accounts import accounts
from seamark.server.accounts.permissions import Role
from seamark.server.app import create_app
from seamark.server.settings import Settings
from tests.journey.conftest import Service
from tests.journey.visitor import PASSWORD, Visitor

pytestmark = [pytest.mark.browser, pytest.mark.host, pytest.mark.slow]

ADMIN = "sees-all"
LIGHT_KB = 300  # of a page with all that it loads but three.js, compressed
PHONE_PX = 375
OPEN_DETAILS = "for (const part of document.querySelectorAll('details')) part.open = true"


@pytest.fixture(scope="module")
def paths(service: Service, finished: tuple[int, Any]) -> list[str]:
    """The addresses of all pages; an admin has been created who may see them."""
    values = {"data": service.data, "secret_key": "x", "broker_url": "redis://127.0.0.1:1/0"}
    app = create_app(Settings.model_validate(values))
    with app.extensions["seamark"].database.writing() as session:
        admin = accounts.sign_up(session, ADMIN, PASSWORD, role=Role.ADMIN)
        create_first(session, admin.id)
    found = pages(app, run_id=finished[0])
    app.extensions["seamark"].close()
    return found


@pytest.fixture
def admin(chromium: Browser, service: Service, scheme: Any) -> Iterator[Visitor]:
    """An admin who has signed in, in a theme."""
    context = chromium.new_context(color_scheme=scheme, viewport={"width": 1280, "height": 900})
    visitor = Visitor(context.new_page(), service.url)
    visitor.sign_in(ADMIN)
    yield visitor
    context.close()


class Weight:
    """Adds up what pages load."""

    def __init__(self, page: Page) -> None:
        self.bytes = 0
        cdp = page.context.new_cdp_session(page)
        cdp.send("Network.enable")
        cdp.on("Network.responseReceived", self._received)
        cdp.on("Network.loadingFinished", self._finished)
        self._vendored: set[str] = set()

    def _received(self, event: dict[str, Any]) -> None:
        if "/vendor/three/" in event["response"]["url"]:
            self._vendored.add(event["requestId"])

    def _finished(self, event: dict[str, Any]) -> None:
        if event["requestId"] not in self._vendored:
            self.bytes += int(event["encodedDataLength"])


@pytest.mark.timeout(600)
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_every_page_is_accessible_light_and_as_wide_as_a_phone_and_has_no_error(
    admin: Visitor, paths: list[str], scheme: str
) -> None:
    page, found = admin.page, list[str]()
    weight = Weight(page)
    assert len(paths) > 20

    for path in paths:
        weight.bytes = 0
        answer = page.goto(admin.url + path, wait_until="load")
        assert answer is not None
        assert answer.status == 200, path
        page.evaluate(OPEN_DETAILS)
        axe = Axe().run(page)
        if axe.violations_count:
            found.append(f"{path}: {axe.generate_report()}")
        if weight.bytes > LIGHT_KB * 1000:
            found.append(f"{path}: {weight.bytes / 1000:.0f} KB")
        page.set_viewport_size({"width": PHONE_PX, "height": 800})
        if (width := page.evaluate("document.documentElement.scrollWidth")) > PHONE_PX:
            found.append(f"{path}: {width} px wide on a phone")
        page.set_viewport_size({"width": 1280, "height": 900})

    assert "\n".join(found) == ""
    assert (admin.errors, admin.violations()) == ([], [])
