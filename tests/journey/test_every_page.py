"""Every page that a browser can open: accessible, light, as wide as a phone, without errors.

The pages come from the routes of the application, so that a new page is tested as well. Of routes
that lead to the same address, one is looked at.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from playwright.sync_api import Browser, Page

from performance.service.database.requests import create_first, pages
from seamark.server.accounts import accounts
from seamark.server.accounts.permissions import Role
from seamark.server.app import create_app
from seamark.server.settings import Settings
from tests.journey import accessibility
from tests.journey.service import Service
from tests.journey.visitor import PASSWORD, Visitor

pytestmark = [pytest.mark.browser, pytest.mark.host, pytest.mark.slow]

ADMIN = "sees-all"
LIGHT_KB = 300  # of a page with all that it loads, compressed
LEFT_OUT = ("/vendor/three/", "/api/v1/")  # the library for 3D, and the data of a run
PHONE_PX = 375
DESKTOP: Any = {"width": 1280, "height": 900}
PHONE: Any = {"width": PHONE_PX, "height": 800}
WIDTH = "document.documentElement.scrollWidth"


@pytest.fixture(scope="module")
def paths(service: Service, finished: tuple[int, Any]) -> list[str]:
    """The addresses of all pages; an admin has been created who may see them."""
    values = {"data": service.data, "secret_key": "x", "broker_url": "redis://127.0.0.1:1/0"}
    app = create_app(Settings.model_validate(values))
    with app.extensions["seamark"].database.writing() as session:
        admin = accounts.sign_up(session, ADMIN, PASSWORD, role=Role.ADMIN)
        create_first(session, admin.id)
    found = pages(app, run_id=finished[0], user="player", user_id=admin.id)
    app.extensions["seamark"].close()
    return found


class Weight:
    """Adds up what a page loads."""

    def __init__(self, page: Page) -> None:
        self.bytes = 0
        self._left_out: set[str] = set()
        cdp = page.context.new_cdp_session(page)
        cdp.send("Network.enable")
        cdp.send("Network.setCacheDisabled", {"cacheDisabled": True})
        cdp.on("Network.responseReceived", self._received)
        cdp.on("Network.loadingFinished", self._finished)

    def _received(self, event: dict[str, Any]) -> None:
        if any(part in event["response"]["url"] for part in LEFT_OUT):
            self._left_out.add(event["requestId"])

    def _finished(self, event: dict[str, Any]) -> None:
        if event["requestId"] not in self._left_out:
            self.bytes += int(event["encodedDataLength"])


@contextmanager
def _signed_in(chromium: Browser, service: Service) -> Iterator[Visitor]:
    context = chromium.new_context(color_scheme="light", viewport=DESKTOP, reduced_motion="reduce")
    visitor = Visitor(context.new_page(), service.url)
    visitor.sign_in(ADMIN)
    yield visitor
    context.close()


def _defects(page: Page, weight: Weight) -> Iterator[str]:
    """Yield what is wrong with the page that is open."""
    if weight.bytes > LIGHT_KB * 1000:
        yield f"{weight.bytes / 1000:.0f} KB"
    yield from accessibility.defects_in_both_themes(page)
    page.set_viewport_size(PHONE)
    for _ in range(20):  # charts follow the size of the window a frame later
        if (width := page.evaluate(WIDTH)) <= PHONE_PX:
            break
        page.wait_for_timeout(100)
    else:
        yield f"{width} px wide on a phone"
    page.set_viewport_size(DESKTOP)


@pytest.mark.timeout(1200)
def test_every_page_is_accessible_light_and_as_wide_as_a_phone_and_has_no_error(
    chromium: Browser, service: Service, paths: list[str]
) -> None:
    found, seen = list[str](), set[str]()
    assert len(paths) > 20

    with _signed_in(chromium, service) as admin:
        weight = Weight(admin.page)
        for path in paths:
            weight.bytes = 0
            answer = admin.page.goto(admin.url + path, wait_until="load")
            assert answer is not None
            assert answer.status == 200, path
            if answer.url not in seen:
                found += [f"{path}: {defect}" for defect in _defects(admin.page, weight)]
            seen.add(answer.url)

    assert "\n".join(found) == ""
    assert admin.errors == []


def _styled(background: str, colours: str) -> str:
    parts = "".join(f'<b style="color: var(--text)">{text}</b>' for text in (")", "Depth"))
    row = f'<p style="background: var(--below)">{parts}</p>'
    return f"""<!doctype html><html lang="en"><title>Rows</title><style>
        :root {{ --below: white; --text: black; background: white }}
        :root[data-theme="dark"] {{ --below: black; --text: white; background: black }}
        :root[data-theme="dark"] .odd {{ --below: {background} }}
        :root[data-theme="{colours}"] .faint {{ --text: grey; opacity: 0.6 }}
        </style><main><h1>Rows</h1>{row * 3}<div class="odd">{row}</div>{row}
        <div class="faint">{row}</div></main></html>"""


@pytest.mark.parametrize(
    ("background", "faint_in", "found"),
    [
        ("black", "none", []),
        ("lightgrey", "none", ["dark"]),
        ("black", "dark", ["dark"]),
        ("black", "light", ["light"]),
    ],
)
def test_one_faint_text_among_others_of_its_kind_is_found_in_the_theme_that_it_is_faint_in(
    chromium: Browser, background: str, faint_in: str, found: list[str]
) -> None:
    page = chromium.new_page()
    page.set_content(_styled(background, faint_in))

    reports = list(accessibility.defects_in_both_themes(page))

    assert [report.partition(":")[0] for report in reports] == found
    assert all("color-contrast" in report for report in reports)
    page.close()


def test_a_text_among_its_like_is_found_above_a_part_of_the_page_that_makes_it_faint(
    chromium: Browser,
) -> None:
    page = chromium.new_page()
    row = '<p style="height: 20px; margin: 0">Depth of the vehicle</p>'
    box = "position: absolute; left: 0; width: 100%; height: 20px; background: #555; z-index: -1"
    page.set_content(f"""<!doctype html><html lang="en"><title>Rows</title>
        <body style="margin: 0"><main style="position: relative; color: black; z-index: 0">
        <h1 style="height: 40px; margin: 0">Rows</h1>{row * 3}
        <div style="top: 60px; {box}"></div></main></body></html>""")

    (report,) = accessibility.defects(page)

    assert "color-contrast" in report
    page.close()
