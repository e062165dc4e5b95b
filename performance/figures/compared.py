"""Draw the pictures of docs/compare.md.

Writes docs/figures/compare-page.webp, the moving docs/figures/compare-observer.webp, and a still of
it for people who want less motion. It runs the programs of docs/tutorial.md in a service of its
own, as the page tells its readers to, and takes the pictures in Chromium without a graphics card.
"""

import tempfile
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path

from PIL import Image, ImageOps
from playwright.sync_api import Page

from performance import FIGURES
from performance.figures.player import QUALITY
from performance.figures.showcase import wait_for_runs
from performance.figures.tutorial import BENCHMARK, SEED, programs
from performance.service.web.browser import chromium, picture
from seamark.client import Client
from seamark.server.accounts import accounts
from seamark.server.database.engine import Database
from seamark.server.runs.publication import publications
from seamark.server.runs.publication.publications import Terms
from tests.services.embedded import cancel_baselines, started

COMPARED = ("a disturbance observer", "P")  # the first one is followed
RUN = {"vehicle": "bluerov2-heavy", "levels": [0.7], "level_duration_s": 20.0, "settle_s": 5.0}
OPTIONS = " ".join(  # the same on the command line
    f"--set {name}={str(value).strip('[]').removesuffix('.0')}" for name, value in RUN.items()
)
SHOWN_S = 9.0  # the moment of the still picture: P has just lost the target
STEP_S, FRAMES = 0.5, 40  # of the moving picture: all of the 20 s
FRAME_MS = 250  # twice as fast as the vehicles
WIDTH = 760  # [px] of the moving picture
SETTLED_MS = 1500  # until the scene and the cameras show the new moment with all pixels


def main(_arguments: Sequence[str]) -> int:
    """Write the pictures."""
    with tempfile.TemporaryDirectory(prefix="seamark-compared-") as folder:
        with started(Path(folder) / "data") as (address, _):
            ids = _recorded(address, Path(folder))
            with chromium() as browser:
                page = browser.new_page(viewport={"width": 1280, "height": 900})
                page.goto(f"{address}/compare?runs={','.join(map(str, ids))}")
                _draw(page)
    return 0


def _recorded(address: str, folder: Path) -> list[int]:
    """Return public runs of the compared programs, which have ended."""
    with closing(Database(f"sqlite:///{folder / 'data' / 'seamark.db'}")) as database:
        cancel_baselines(database)
        with database.writing() as session:
            user = accounts.sign_up(session, "ada", None)
            token = accounts.new_token(session, user.id, "laptop", ("read", "submit"))
        program, ids = folder / "controller.py", []
        with Client(address, token) as client:
            for title in COMPARED:
                program.write_text(programs()[title], encoding="utf-8")
                run = client.submit(
                    BENCHMARK, program=program, config=RUN, seed=SEED, title=_method(title)
                )
                ids.append(run.id)
        wait_for_runs(database)
        with database.writing() as session:
            for run_id, title in zip(ids, COMPARED, strict=True):
                publications.publish(session, run_id, Terms(method=_method(title)))
    return ids


def _method(title: str) -> str:
    return title.removeprefix("a ").capitalize()


def _draw(page: Page) -> None:
    page.locator("[data-stage][data-pictures]").wait_for()
    _go_to(page, SHOWN_S)
    page.locator("[data-time]").blur()
    picture(page).save(FIGURES / "compare-page.webp", quality=QUALITY)
    views = page.locator("[data-views]")
    frames: list[Image.Image] = []
    for number in range(FRAMES):
        _go_to(page, STEP_S * number)
        frame = picture(views)
        # A line of numbers that wraps makes a view a little higher; the pictures are of one size.
        size = frames[0].size if frames else (WIDTH, WIDTH * frame.height // frame.width)
        frames.append(ImageOps.fit(frame, size, centering=(0.0, 0.0)))
    frames[round(SHOWN_S / STEP_S)].save(FIGURES / "compare-observer-still.webp", quality=QUALITY)
    first, *rest = frames
    first.save(
        FIGURES / "compare-observer.webp",
        save_all=True, append_images=rest, duration=FRAME_MS, loop=0, quality=QUALITY,
    )  # fmt: skip


def _go_to(page: Page, seconds: float) -> None:
    page.locator("[data-time]").evaluate(_SET_TIME, seconds)
    page.wait_for_timeout(SETTLED_MS)


_SET_TIME = """(slider, seconds) => {
  slider.value = String(seconds);
  slider.dispatchEvent(new Event("input"));
}"""
