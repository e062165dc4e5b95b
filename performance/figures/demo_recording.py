"""Record the run that the home page shows.

Writes server/runs/showing/demo/: its telemetry and digest, and what the player needs beside
it. The telemetry is that of `seamark run` with the same settings and seed. Writes
templates/static/demo/: pictures of the scene, moving and still, for the time until the player
draws, from Chromium without a graphics card.
"""

import shutil
import tempfile
import zipfile
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
import orjson
from numpy.typing import NDArray
from PIL import Image
from playwright.sync_api import Page

from performance.service.web.browser import chromium, picture
from performance.service.web.player import served
from seamark import templates
from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.showing import camera_view, recorded_demo, scene
from seamark.server.runs.showing.recorded_demo import FOLDER, IMAGE_EVERY_S, IMAGES, SCENE, TEXTURES
from seamark.server.settings import Settings
from seamark.sim import registry
from seamark.sim.engine.program import BuiltIn
from seamark.sim.engine.trial import run_trial
from seamark.sim.recording import telemetry
from seamark.sim.recording.telemetry import STEP_US, Rows

POSTERS = Path(templates.__file__).parent / "static" / "demo"
IMAGE_SIZE, IMAGE_QUALITY = (320, 240), 48
TEXTURE_SIZE, TEXTURE_QUALITY = (384, 384), 70
POSTER_SIZE = (480, 330)  # [px], the aspect of the box on the home page
POSTER_FROM_S, POSTER_STEP_S, POSTER_PICTURES = 40.0, 0.6, 28  # the last level
POSTER_MS = 120  # of each picture: five times as fast as the run
POSTER_QUALITY, STILL_QUALITY = 45, 80
STILL_S = 47.0  # the moment of the still picture, in which current, trail and camera are seen
SETTLED_MS = 1500  # until the scene shows the new moment with all pixels
Picture = NDArray[np.uint8]


def record(folder: Path) -> None:
    """Write the telemetry and its digest below a folder that has none."""
    files = recorded_demo.files(folder)
    config = registry.benchmark(recorded_demo.BENCHMARK).read(recorded_demo.SETTINGS)
    program = BuiltIn(recorded_demo.CONTROLLER, config)

    def store(rows: Rows) -> None:
        rows = rows.copy()
        rows[:, STEP_US] = np.nan  # wall time, the only column that differs each time
        files.append_rows(rows)

    run_trial(
        recorded_demo.BENCHMARK,
        config,
        program,
        seed=recorded_demo.SEED,
        trial=0,
        on_rows=store,
    )
    files.write_json("manifest.json", {"digest": telemetry.digest(files.rows())})


def main(_arguments: Sequence[str]) -> int:
    """Write all files of the demo."""
    shutil.rmtree(FOLDER, ignore_errors=True)
    (FOLDER / "runs").mkdir(parents=True)
    POSTERS.mkdir(exist_ok=True)
    record(FOLDER)
    with tempfile.TemporaryDirectory() as folder, served(Path(folder)) as (url, settings):
        _write_surroundings(settings)
        _write_images(settings, recorded_demo.files())
        with chromium() as browser:
            page = browser.new_page(
                bypass_csp=True,
                reduced_motion="reduce",
                viewport={"width": 1280, "height": 900},
            )
            _write_poster(page, url)
    return 0


def _write_surroundings(settings: Settings) -> None:
    run = recorded_demo.run()
    described = scene.describe(settings, run, trial=0, level=0)
    (FOLDER / SCENE).write_bytes(orjson.dumps(described, option=orjson.OPT_INDENT_2))
    for part, name in TEXTURES.items():
        image = _decoded(scene.texture(settings, run, trial=0, level=0, part=part))
        height, width = image.shape[:2]
        size = min((width, height), TEXTURE_SIZE)
        (FOLDER / name).write_bytes(_jpeg(image, size, TEXTURE_QUALITY))


def _write_images(settings: Settings, files: RunFiles) -> None:
    run = recorded_demo.run()
    with zipfile.ZipFile(FOLDER / IMAGES, "w", zipfile.ZIP_STORED) as archive:
        for t in np.arange(0.0, run.t_simulated, IMAGE_EVERY_S):
            image = camera_view.render(settings, run, trial=0, t=float(t), files=files)
            if image is not None:
                entry = zipfile.ZipInfo(f"{t:05.1f}.jpg")  # without the time of writing
                archive.writestr(entry, _jpeg(_decoded(image), IMAGE_SIZE, IMAGE_QUALITY))


def _write_poster(page: Page, url: str) -> None:
    page.goto(f"{url}/demo")
    page.set_default_timeout(120_000)
    page.locator("[data-stage][data-pictures]").wait_for()
    page.add_style_tag(content=_POSTER_STAGE)
    page.wait_for_timeout(SETTLED_MS)
    frames = [_frame(page, POSTER_FROM_S + POSTER_STEP_S * at) for at in range(POSTER_PICTURES)]
    first, *rest = [frame.resize(POSTER_SIZE) for frame in frames]
    first.save(
        POSTERS / "moving.webp",
        save_all=True, append_images=rest, duration=POSTER_MS, loop=0, quality=POSTER_QUALITY,
        method=6,
    )  # fmt: skip
    _frame(page, STILL_S).save(POSTERS / "still.webp", quality=STILL_QUALITY, method=6)


_POSTER_STAGE = """.site-header { display: none !important; }
  [data-stage] { position: fixed !important; inset: 0 auto auto 0; z-index: 9;
  width: 720px !important; height: 495px !important; aspect-ratio: auto !important; }"""


def _frame(page: Page, seconds: float) -> Image.Image:
    page.locator("[data-time]").fill(f"{seconds:g}")
    page.wait_for_timeout(SETTLED_MS)
    return picture(page.locator("[data-stage]"))


def _decoded(jpeg: bytes) -> Picture:
    image = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)
    return np.asarray(image, np.uint8)


def _jpeg(image: Picture, size: tuple[int, int], quality: int) -> bytes:
    small = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
    return cv2.imencode(".jpg", small, [cv2.IMWRITE_JPEG_QUALITY, quality])[1].tobytes()
