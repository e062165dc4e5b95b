"""Draw every page, in both themes and on a phone.

Writes screenshots/PAGE-{light,dark,phone}.webp in Chromium, of a service with its own runs. Git
ignores them, except two that the README shows, which are copied to docs/figures.
"""

import re
import shutil
from collections.abc import Sequence

from playwright.sync_api import Browser

from performance import FIGURES, ROOT
from performance.figures.showcase import Showcase, showcase
from performance.service.web.browser import chromium, picture

FOLDER = ROOT / "screenshots"
KEPT = {"sweeps-1-light": "sweep", "leaderboards-currents-v1-dark": "leaderboard"}
LOOKS = {
    "light": {"color_scheme": "light", "viewport": {"width": 1280, "height": 900}},
    "dark": {"color_scheme": "dark", "viewport": {"width": 1280, "height": 900}},
    "phone": {"color_scheme": "light", "viewport": {"width": 375, "height": 800}},
}
SETTLED_MS = 5000  # until pictures and charts are there, and the scene has all pixels
QUALITY = 60


def main(_arguments: Sequence[str]) -> int:
    """Write all pictures."""
    FOLDER.mkdir(exist_ok=True)
    with showcase() as service, chromium() as browser:
        for look in LOOKS:
            _draw(browser, service, look)
    for name, figure in KEPT.items():
        shutil.copy(FOLDER / f"{name}.webp", FIGURES / f"{figure}.webp")
    return 0


def _draw(browser: Browser, service: Showcase, look: str) -> None:
    context = browser.new_context(**LOOKS[look])  # type: ignore[arg-type]
    page = context.new_page()
    page.goto(f"{service.address}/sign-in")
    page.get_by_label("Name").fill(service.name)
    page.get_by_label("Password").fill(service.password)
    page.get_by_role("main").get_by_role("button", name="Sign in").click()
    page.wait_for_url(lambda url: "sign-in" not in url)
    for path in service.paths:
        page.goto(service.address + path)
        page.wait_for_timeout(SETTLED_MS)
        name = re.sub(r"[^a-z0-9]+", "-", path.lower()).strip("-") or "home"
        picture(page).save(FOLDER / f"{name}-{look}.webp", quality=QUALITY)
    context.close()
