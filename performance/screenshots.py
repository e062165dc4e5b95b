"""Draw every page, in both themes and on a phone: python -m performance.screenshots.

Writes docs/screenshots/PAGE-{light,dark,phone}.webp in Chromium, of a service with its own runs.
"""

import re
import secrets
import shutil
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from playwright.sync_api import Browser, sync_playwright
from sqlalchemy import exists, select

from performance.player import SOFTWARE
from performance.player_figures import picture
from performance.requests import create_first, pages
from seamark.client import Client
from seamark.server.accounts import accounts
from seamark.server.accounts.permissions import Role
from seamark.server.app import create_app
from seamark.server.database.engine import Database
from seamark.server.database.tables import Run
from seamark.server.runs.states import LIVE
from seamark.server.settings import Settings
from tests.services.embedded import started

FOLDER = Path(__file__).parents[1] / "docs" / "screenshots"
NAME, BASELINE = "ada", "seamark-pi"
SHORT = {"levels": [0.0, 0.4], "level_duration_s": 40.0, "settle_s": 5.0}
BROKEN = b"""class Controller:
    def __init__(self, config):
        self.gain = 1.0

    def reset(self, level):
        pass

    def step(self, observation):
        return [observation.error[0] / (observation.time - 10.0), 0.0, 0.0, 0.0]
"""
LOOKS = {
    "light": {"color_scheme": "light", "viewport": {"width": 1280, "height": 900}},
    "dark": {"color_scheme": "dark", "viewport": {"width": 1280, "height": 900}},
    "phone": {"color_scheme": "light", "viewport": {"width": 375, "height": 800}},
}
SETTLED_MS = 1500  # until pictures, charts and the scene are there
POLL_S = 1.0
QUALITY = 60


@dataclass(frozen=True)
class Filled:
    """A service with something on every page, and the password of its admin."""

    address: str
    password: str
    paths: list[str]


def main() -> int:
    """Write all pictures."""
    FOLDER.mkdir(exist_ok=True)
    with filled() as service, sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=SOFTWARE
        )
        for look in LOOKS:
            _draw(browser, service, look)
        browser.close()
    return 0


@contextmanager
def filled() -> Iterator[Filled]:
    """Start a service with an admin, a class, a sweep, baselines, and runs of each outcome."""
    with tempfile.TemporaryDirectory(prefix="seamark-pictures-") as folder:
        data = Path(folder) / "data"
        with started(data) as (address, _):
            password = secrets.token_urlsafe(12)
            database = Database(f"sqlite:///{data / 'seamark.db'}")
            with closing(database):
                with database.writing() as session:
                    user = accounts.sign_up(session, NAME, password, role=Role.ADMIN)
                    create_first(session, user.id)
                    token = accounts.new_token(session, user.id, "pictures", ("read", "submit"))
                broken = Path(folder) / "broken.py"
                broken.write_bytes(BROKEN)
                with Client(address, token) as client:
                    failed = _submit(client, program=broken)
                    run_id = _submit(client, controller="pi")
                _wait(database)
            values = {"data": data, "secret_key": "x", "broker_url": "redis://127.0.0.1:1/0"}
            app = create_app(Settings.model_validate(values))
            paths = [*pages(app, run_id=run_id, user=BASELINE), f"/runs/{failed}", "/nowhere"]
            app.extensions["seamark"].close()
            yield Filled(address, password, paths)


def _submit(client: Client, **program: Any) -> int:
    run_id: int = client.submit("currents-v1", config=SHORT, seed=3, **program)["id"]
    return run_id


def _wait(database: Database) -> None:
    """Wait until all runs have ended, those of the baselines too."""
    while True:
        with database.reading() as session:
            if not session.scalar(select(exists().where(Run.state.in_(LIVE)))):
                return
        time.sleep(POLL_S)


def _draw(browser: Browser, service: Filled, look: str) -> None:
    context = browser.new_context(**LOOKS[look])  # type: ignore[arg-type]
    page = context.new_page()
    page.goto(f"{service.address}/sign-in")
    page.get_by_label("Name").fill(NAME)
    page.get_by_label("Password").fill(service.password)
    page.get_by_role("main").get_by_role("button", name="Sign in").click()
    page.wait_for_url(lambda url: "sign-in" not in url)
    for path in service.paths:
        page.goto(service.address + path)
        page.wait_for_timeout(SETTLED_MS)
        name = re.sub(r"[^a-z0-9]+", "-", path.lower()).strip("-") or "home"
        picture(page.screenshot()).save(FOLDER / f"{name}-{look}.webp", quality=QUALITY)
    context.close()


if __name__ == "__main__":
    sys.exit(main())
