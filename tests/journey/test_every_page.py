"""Every page that a browser can open: accessible, light, as wide as a phone, without errors.

The pages come from the routes of the application, so that a new page is tested as well. Of routes
that lead to the same address, one is looked at.
"""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from playwright.sync_api import Browser, Page
from sqlalchemy import update

from performance.service.database.requests import create_first, pages
from seamark.server.accounts import accounts
from seamark.server.accounts.permissions import Role
from seamark.server.app import create_app
from seamark.server.database.rejudgement_tables import Rejudgement
from seamark.server.settings import Settings
from tests.journey import accessibility
from tests.journey.service import Service
from tests.journey.visitor import PASSWORD, PHONE_PX, Visitor, width_on_a_phone

pytestmark = [pytest.mark.browser, pytest.mark.host, pytest.mark.slow]

ADMIN = "sees-all"
LIGHT_KB = 290  # of a page with all that it loads, compressed; the logo comes once for all pages
LEFT_OUT = ("/vendor/three/", "/api/v1/")  # the library for 3D, and the data of a run
DESKTOP: Any = {"width": 1280, "height": 900}


# What shows the player of a run, of which test_player looks with axe.
PLAYERS = ("run.show", "run.embed", "publications.permanent")


@pytest.fixture(scope="module")
def views(service: Service, finished: tuple[int, Any]) -> dict[str, str]:
    """The view behind the address of each page; an admin has been created who may see them."""
    values = {"data": service.data, "secret_key": "x", "broker_url": "redis://127.0.0.1:1/0"}
    app = create_app(Settings.model_validate(values))
    with app.extensions["seamark"].database.writing() as session:
        admin = accounts.sign_up(session, ADMIN, PASSWORD, role=Role.ADMIN)
        create_first(session, admin.id)
        # Other tests on this service may start a rejudgement of theirs, of which one waits at most.
        discarded = {"decision": "discarded", "decided_by": ADMIN, "decided_at": time.time()}
        session.execute(
            update(Rejudgement).where(Rejudgement.created_by == "root").values(discarded)
        )
    found = pages(app, run_id=finished[0], user="player", user_id=admin.id)
    app.extensions["seamark"].close()
    routes = app.url_map.bind("")
    return {path: routes.match(path.partition("?")[0])[0] for path in found}


@pytest.fixture(scope="module")
def paths(views: dict[str, str]) -> list[str]:
    """The addresses of all pages."""
    return list(views)


@pytest.fixture(scope="module")
def fullest(views: dict[str, str]) -> set[str]:
    """The address of one page of each view without a player: of several, the one with most."""
    by_length = sorted(views, key=len)
    return set({views[path]: path for path in by_length if views[path] not in PLAYERS}.values())


class Weight:
    """Adds up what a page loads, also what the browser has kept of an earlier page.

    To load and compile that again for each page took most of the test's time.
    """

    def __init__(self, page: Page) -> None:
        self._urls = dict[str, str]()  # of all requests
        self._loaded = dict[str, int]()  # bytes of what came from an address, at most
        self._page = set[str]()  # the addresses that the page that is open has asked for
        cdp = page.context.new_cdp_session(page)
        cdp.send("Network.enable")
        cdp.on("Network.requestWillBeSent", self._requested)
        cdp.on("Network.loadingFinished", self._finished)

    def next_page(self) -> None:
        self._page.clear()

    def bytes(self) -> int:
        """Return the weight of the page that is open."""
        return sum(self._loaded.get(url, 0) for url in self._page)

    def _requested(self, event: dict[str, Any]) -> None:
        url = event["request"]["url"]
        if not any(part in url for part in LEFT_OUT):
            self._urls[event["requestId"]] = url
            self._page.add(url)

    def _finished(self, event: dict[str, Any]) -> None:
        if (url := self._urls.get(event["requestId"])) is not None:
            self._loaded[url] = max(self._loaded.get(url, 0), int(event["encodedDataLength"]))


@contextmanager
def _signed_in(chromium: Browser, service: Service) -> Iterator[tuple[Visitor, Weight]]:
    context = chromium.new_context(color_scheme="light", viewport=DESKTOP, reduced_motion="reduce")
    visitor = Visitor(context.new_page(), service.url)
    weight = Weight(visitor.page)  # before the first page, whose parts the browser keeps
    visitor.sign_in(ADMIN)
    yield visitor, weight
    context.close()


def _too_wide(page: Page) -> Iterator[str]:
    """Yield how wide the page that is open is on a phone, if it is wider."""
    if (width := width_on_a_phone(page)) > PHONE_PX:
        yield f"{width} px wide on a phone"
    page.set_viewport_size(DESKTOP)


def _opened(admin: Visitor, weight: Weight, paths: list[str]) -> Iterator[str]:
    """Open one page after the other, and yield its path."""
    seen = set[str]()
    for path in paths:
        weight.next_page()
        answer = admin.page.goto(admin.url + path, wait_until="load")
        assert answer is not None
        assert answer.status == 200, path
        if answer.url not in seen:
            yield path
        seen.add(answer.url)


@pytest.mark.timeout(1200)
def test_every_page_is_light_and_as_wide_as_a_phone_and_has_no_error_and_one_of_each_is_accessible(
    chromium: Browser, service: Service, paths: list[str], fullest: set[str]
) -> None:
    found = list[str]()
    assert len(paths) > 20
    assert len(fullest) > 20

    with _signed_in(chromium, service) as (admin, weight):
        for path in _opened(admin, weight, paths):
            if (loaded := weight.bytes()) > LIGHT_KB * 1000:
                found.append(f"{path}: {loaded / 1000:.0f} KB")
            if path in fullest:
                found += [f"{path}: {defect}" for defect in accessibility.defects(admin.page)]
            found += [f"{path}: {defect}" for defect in _too_wide(admin.page)]

    assert "\n".join(found) == ""
    assert admin.errors == []


@pytest.mark.long  # short: one page of each view above, and the run page in test_player
@pytest.mark.timeout(1200)
def test_further_pages_of_a_view_are_accessible_too(
    chromium: Browser, service: Service, paths: list[str], fullest: set[str]
) -> None:
    further = [path for path in paths if path not in fullest]

    with _signed_in(chromium, service) as (admin, weight):
        found = [
            f"{path}: {defect}"
            for path in _opened(admin, weight, further)
            for defect in accessibility.defects(admin.page)
        ]

    assert "\n".join(found) == ""


@pytest.mark.long  # short: the dark home page and form below, and the run page in test_player
@pytest.mark.timeout(1200)
def test_every_page_has_enough_contrast_in_the_dark_theme_too(
    chromium: Browser, service: Service, paths: list[str]
) -> None:
    assert _faint_when_dark(chromium, service, paths) == ""


def test_the_home_page_and_a_form_have_enough_contrast_in_the_dark_theme_too(
    chromium: Browser, service: Service, paths: list[str]
) -> None:
    assert _faint_when_dark(chromium, service, ["/", "/submit/currents-v2"]) == ""


def _faint_when_dark(chromium: Browser, service: Service, paths: list[str]) -> str:
    with _signed_in(chromium, service) as (admin, weight):
        return "\n".join(
            f"{path}: {defect}"
            for path in _opened(admin, weight, paths)
            for defect in accessibility.faint_texts(admin.page, "dark")
        )


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


@pytest.fixture(scope="module")
def page(chromium: Browser) -> Iterator[Page]:
    """A page of its own, for contents that a test writes."""
    opened = chromium.new_page()
    yield opened
    opened.close()


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
    page: Page, background: str, faint_in: str, found: list[str]
) -> None:
    page.set_content(_styled(background, faint_in))

    reports = {theme: [*accessibility.faint_texts(page, theme)] for theme in ("light", "dark")}

    assert [theme for theme, faint in reports.items() if faint] == found
    assert all("color-contrast" in report for faint in reports.values() for report in faint)


def test_a_text_among_its_like_is_found_above_a_part_of_the_page_that_makes_it_faint(
    page: Page,
) -> None:
    row = '<p style="height: 20px; margin: 0">Depth of the vehicle</p>'
    box = "position: absolute; left: 0; width: 100%; height: 20px; background: #555; z-index: -1"
    page.set_content(f"""<!doctype html><html lang="en"><title>Rows</title>
        <body style="margin: 0"><main style="position: relative; color: black; z-index: 0">
        <h1 style="height: 40px; margin: 0">Rows</h1>{row * 3}
        <div style="top: 60px; {box}"></div></main></body></html>""")

    (report,) = accessibility.defects(page)

    assert "color-contrast" in report
