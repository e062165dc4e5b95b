"""Draw the picture of the player.

Writes docs/figures/run-page.webp, from a run of the built-in controller in Chromium without a
graphics card.
"""

import tempfile
from collections.abc import Sequence
from pathlib import Path

from playwright.sync_api import Page

from performance import FIGURES
from performance.service.web.browser import chromium, picture
from performance.service.web.player import opened, recorded, served

RUN = {"levels": [0.1, 0.4], "level_duration_s": 60.0}
SHOWN_S = 96.0  # the moment of the still picture
QUALITY = 70
SETTLED_MS = 2000  # until scene and camera show the new moment with all pixels


def main(_arguments: Sequence[str]) -> int:
    """Write the picture."""
    with tempfile.TemporaryDirectory() as folder, served(Path(folder)) as (url, settings):
        address = f"{url}/runs/{recorded(settings, RUN)}"
        with chromium() as browser:
            _, page = opened(browser, address)
            page.set_default_timeout(120_000)
            _draw(page)
    return 0


def _draw(page: Page) -> None:
    page.locator("[data-stage]").scroll_into_view_if_needed()
    _go_to(page, SHOWN_S)
    page.locator("[data-time]").blur()
    page.evaluate("scrollTo(0, document.querySelector('[data-player]').offsetTop - 70)")
    page.wait_for_timeout(SETTLED_MS)
    picture(page).save(FIGURES / "run-page.webp", quality=QUALITY)


def _go_to(page: Page, seconds: float) -> None:
    page.locator("[data-time]").fill(f"{seconds:g}")
    page.wait_for_timeout(SETTLED_MS)
