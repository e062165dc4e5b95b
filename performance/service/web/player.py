"""How smoothly Chromium, without a graphics card, plays a run; how soon a long run opens.

Frame rates are those of the scene at 1280x720 beside an empty WebGL canvas of that size in the same
browser. The server is in the same process, so it takes its share of the cores; while a run is
live, so does the simulator, at its full speed.
"""

import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from playwright.sync_api import Browser, Page
from sqlalchemy import update
from werkzeug.serving import make_server

from performance.service.web import streams
from performance.service.web.browser import chromium
from performance.tables import Row
from seamark.server.accounts.permissions import Viewer
from seamark.server.app import create_app
from seamark.server.database.engine import Database
from seamark.server.database.schema import upgrade
from seamark.server.database.tables import Run
from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.record.states import RunKind, RunState
from seamark.server.runs.submission import submission, validation
from seamark.server.settings import Settings
from seamark.sim import registry
from seamark.sim.engine.program import BuiltIn
from seamark.sim.engine.trial import run_trial

BENCHMARK, CONTROLLER, SEED = "currents-v1", "pi", 1
LONG = {"levels": [0.05 * level for level in range(10)], "level_duration_s": 600.0}  # 6000 s
SHORT = {"levels": [0.0, 0.4], "level_duration_s": 20.0, "settle_s": 5.0}
WATCHED_MS = 8000
_FIRST_CONTENT = "performance.getEntriesByName('first-contentful-paint')"
SETTLE_MS = 5000  # until the resolution has settled
WIDTH, HEIGHT = 1280, 720
_SIZE_STAGE = """() => {
  const stage = document.querySelector("[data-stage]");
  const size = { width: "1280px", height: "720px" };
  Object.assign(stage.style, { position: "fixed", left: 0, top: 0, ...size });
}"""
_EMPTY_CANVAS = """(milliseconds) => new Promise((done) => {
  const canvas = Object.assign(document.createElement("canvas"), { width: 1280, height: 720 });
  document.body.append(canvas);
  const gl = canvas.getContext("webgl2");
  let pictures = 0;
  const start = performance.now();
  const draw = (now) => {
    gl.clearColor((pictures % 60) / 60, 0, 0, 1);
    gl.clear(gl.COLOR_BUFFER_BIT);
    pictures += 1;
    if (now - start < milliseconds) requestAnimationFrame(draw);
    else done(pictures / (now - start) * 1000);
  };
  requestAnimationFrame(draw);
})"""
_COUNT_LONG_TASKS = """() => {
  window.longest = 0;
  new PerformanceObserver((list) => {
    for (const task of list.getEntries()) window.longest = Math.max(window.longest, task.duration);
  }).observe({ type: "longtask" });
}"""


def rows() -> list[Row]:
    """Return frame rate, longest task and times to open."""
    with tempfile.TemporaryDirectory() as folder, served(Path(folder)) as (url, settings):
        short, long = (recorded(settings, config) for config in (SHORT, LONG))
        with chromium() as browser:
            results = _measured(browser, f"{url}/runs/{short}", f"{url}/runs/{long}")
            results += [_live(browser), *_first_content(browser, url, f"/runs/{long}")]
    return results


def _live(browser: Browser) -> Row:
    """Return the longest task of the page of a run that is computed."""
    with streams.service() as service:
        page = browser.new_page(
            bypass_csp=True,
            viewport={"width": WIDTH, "height": 900},
            extra_http_headers={"Authorization": f"Bearer {service.token}"},
        )
        _open(page, f"http://127.0.0.1:{service.port}/runs/{service.run_id}")
        page.wait_for_timeout(SETTLE_MS)
        longest = _longest_task(page)
        page.close()
    return Row(what="longest task while live (0: below 50)", value=longest, unit="ms")


def _first_content(browser: Browser, url: str, run: str) -> Iterator[Row]:
    """Yield the time [ms] from asking for a page to the first text in it."""
    page = browser.new_page(bypass_csp=True)
    for path in ("/", run, f"/leaderboards/{BENCHMARK}", f"/submit/{BENCHMARK}"):
        page.goto(url + path)
        page.wait_for_function(f"{_FIRST_CONTENT}.length")
        shown = float(page.evaluate(f"{_FIRST_CONTENT}[0].startTime"))
        yield Row(what=f"first content of {path}", value=shown, unit="ms")


def _measured(browser: Browser, short: str, long: str) -> list[Row]:
    opened(browser, short)  # the first page compiles the camera
    open_short, page = opened(browser, short)
    page.close()
    open_long, page = opened(browser, long)
    pictures, scale, longest = _played(page)
    page.goto("about:blank")
    empty = page.evaluate(_EMPTY_CANVAS, WATCHED_MS)
    return [
        Row(what="pictures of the scene", value=pictures, unit="1/s",
            baseline="empty canvas", baseline_value=empty),
        Row(what="its resolution, as a share of each side", value=scale, unit=""),
        Row(what="longest task while playing (0: below 50)", value=longest, unit="ms"),
        Row(what="a run of 6000 s opens", value=open_long, unit="s",
            baseline="a run of 40 s", baseline_value=open_short),
    ]  # fmt: skip


def opened(browser: Browser, address: str) -> tuple[float, Page]:
    """Return the time [s] until charts, camera and scene are there, and the page."""
    page = browser.new_page(bypass_csp=True, viewport={"width": WIDTH, "height": 900})
    return _open(page, address), page


def _open(page: Page, address: str) -> float:
    page.goto(address)
    page.wait_for_function(
        "document.querySelector('[data-pose]').textContent"
        " && !document.querySelector('[data-camera] img').hidden"
        " && document.querySelector('.chart-title output').textContent"
    )
    return float(page.evaluate("performance.now()")) / 1e3


def _longest_task(page: Page) -> float:
    """Watch the page for a while and return its longest task [ms]; 0 without one over 50 ms."""
    page.evaluate(_COUNT_LONG_TASKS)
    page.wait_for_timeout(WATCHED_MS)
    return float(page.evaluate("window.longest"))


def _played(page: Page) -> tuple[float, float, float]:
    """Return pictures per second, the share of the resolution, and the longest task [ms]."""
    page.evaluate(_SIZE_STAGE)
    page.get_by_label("Speed").select_option("5")
    page.keyboard.press("k")
    page.wait_for_timeout(SETTLE_MS)
    stage = page.locator("[data-stage]")
    before, start = int(stage.get_attribute("data-pictures") or 0), page.evaluate("Date.now()")
    longest = _longest_task(page)
    after, end = int(stage.get_attribute("data-pictures") or 0), page.evaluate("Date.now()")
    scale = float(stage.get_attribute("data-scale") or 1)
    return 1e3 * (after - before) / (end - start), scale, longest


@contextmanager
def served(folder: Path) -> Iterator[tuple[str, Settings]]:
    """Serve a data folder that is empty so far; gives the address and the settings."""
    settings = Settings.model_validate(
        {"data": folder, "secret_key": "only-measured", "broker_url": "redis://127.0.0.1:1/0"}
    )
    upgrade(settings)
    server = make_server("127.0.0.1", 0, create_app(settings), threaded=True)
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    yield f"http://127.0.0.1:{server.server_port}", settings
    server.shutdown()


def recorded(settings: Settings, config: dict[str, object]) -> int:
    """Return a public run with the telemetry of a trial."""
    wanted = validation.Submission(
        viewer=Viewer(guest="measured"), benchmark=BENCHMARK, kind=RunKind.PRACTICE, config=config,
        seed=SEED, trials=1, controller=CONTROLLER,
    )  # fmt: skip
    database = Database(settings.database_url)
    with database.writing() as session:
        run_id = submission.submit(session, validation.validate(wanted, settings), settings)
        now = time.time()
        ended = {"state": RunState.SUCCEEDED, "started_at": now, "finished_at": now, "public": True}
        session.execute(update(Run).where(Run.id == run_id).values(**ended))
    database.close()
    files = RunFiles(settings.data, run_id, 1)
    read = registry.benchmark(BENCHMARK).read(config)
    program = BuiltIn(CONTROLLER, read)
    run_trial(BENCHMARK, read, program, seed=SEED, trial=0, on_rows=files.append_rows)
    return run_id
