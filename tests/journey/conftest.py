"""The real service, started by `seamark up` in a temporary folder, and browsers to visit it."""

import asyncio
import contextlib
import os
import shutil
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, expect, sync_playwright

from seamark.server.database.engine import Database
from tests.journey.visitor import RUN_MS, Visitor
from tests.services.embedded import cancel_baselines
from tests.services.ports import free_port
from tests.services.processes import end

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
START_S = 240.0
ROOT = Path(__file__).parents[2]
SHORT = {"levels": [0.0, 0.4], "level_duration_s": 20, "settle_s": 2}
EMBEDDING_PORT = free_port()  # of the other site that may show runs in a frame
PAGE_MS = 30_000  # most that a page takes to change on a loaded machine; Playwright's own is 5 s
expect.set_options(timeout=PAGE_MS)
# WebGL without a graphics card.
SOFTWARE_RENDERING = ["--enable-unsafe-swiftshader"]


@dataclass(frozen=True)
class Service:
    """A running service."""

    url: str
    data: Path


def _is_ready(url: str) -> bool:
    try:
        with urllib.request.urlopen(f"{url}/readyz", timeout=2) as response:  # noqa: S310 - our own
            return bool(response.status == 200)
    except (urllib.error.URLError, OSError):
        return False


def _wait_until_ready(process: "subprocess.Popen[bytes]", url: str, log: Path) -> None:
    deadline = time.monotonic() + START_S
    while not _is_ready(url):
        if process.poll() is not None or time.monotonic() > deadline:
            pytest.fail(f"the service did not start:\n{log.read_text()[-4000:]}")
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(0.2)  # returns at once when the service ends


def _cancel_baselines(url: str) -> None:
    with closing(Database(url)) as database:
        cancel_baselines(database)


@contextlib.contextmanager
def running(**settings: str) -> Iterator[Service]:
    """Run `seamark up` on a free port."""
    with tempfile.TemporaryDirectory(prefix="seamark-journey-") as folder:
        port, data, log = free_port(), Path(folder) / "data", Path(folder) / "log"
        command = [sys.executable, "-m", "seamark.cli.main", "up", "--port", str(port)]
        with log.open("wb") as output:
            process = subprocess.Popen(
                [*command, "--data", str(data)],
                cwd=ROOT,
                env={
                    **os.environ,
                    "SEAMARK_SIGN_UPS_PER_HOUR": "1000",  # all tests sign up from one address
                    "SEAMARK_EMBED_ORIGINS": f"http://localhost:{EMBEDDING_PORT}",
                    **settings,
                },
                stdout=output,
                stderr=subprocess.STDOUT,
            )
        try:
            url = f"http://127.0.0.1:{port}"
            _wait_until_ready(process, url, log)
            yield Service(url, data)
        finally:
            end(process, 30.0)


@pytest.fixture(scope="session")
def service() -> Iterator[Service]:
    """The service with its embedded defaults: SQLite and its own broker."""
    with running() as embedded:
        _cancel_baselines(f"sqlite:///{embedded.data / 'seamark.db'}")
        yield embedded


@pytest.fixture
def production(postgres_url: str, redis_tcp_url: str) -> Iterator[Service]:
    """The same service on PostgreSQL and a broker over TCP, by settings alone."""
    variables = {"SEAMARK_DATABASE_URL": postgres_url, "SEAMARK_BROKER_URL": redis_tcp_url}
    with running(**variables) as started:
        _cancel_baselines(postgres_url)
        yield started


@pytest.fixture(scope="session")
def chromium() -> Iterator[Browser]:
    """The Chromium of this system, headless."""
    if CHROMIUM is None:
        pytest.skip("chromium is not installed (Debian: apt-get install chromium)")
    options = ["--disable-background-networking", "--disable-component-update", "--no-first-run"]
    if os.geteuid() == 0:
        options.append("--no-sandbox")  # Chromium refuses its own sandbox as root
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=CHROMIUM, args=[*options, *SOFTWARE_RENDERING]
        )
        yield browser
        asyncio._set_running_loop(browser._loop)
        browser.close()


# After each call Playwright marks its event loop as the running one of this thread, while a
# browser is open. Between tests it must not be: `asyncio.run` in another test would not start.
_SUSPENDED = pytest.StashKey[asyncio.AbstractEventLoop]()


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Function) -> None:
    """Resume Playwright's event loop for a test with a browser."""
    if "chromium" in item.fixturenames:
        asyncio._set_running_loop(item.session.stash.get(_SUSPENDED, None))


@pytest.hookimpl(wrapper=True)
def pytest_runtest_teardown(item: pytest.Item) -> Iterator[None]:
    """Suspend the loop when all that the test leaves behind is closed."""
    if (loop := asyncio._get_running_loop()) is not None:
        item.session.stash[_SUSPENDED] = loop
    asyncio._set_running_loop(item.session.stash.get(_SUSPENDED, None))
    try:
        yield
    finally:
        asyncio._set_running_loop(None)


@pytest.fixture
def visitor(chromium: Browser, service: Service) -> Iterator[Visitor]:
    """A visitor with a desktop screen."""
    context = chromium.new_context(viewport={"width": 1280, "height": 900})
    yield Visitor(context.new_page(), service.url)
    context.close()


@pytest.fixture
def phone(chromium: Browser, service: Service) -> Iterator[Visitor]:
    """A visitor with a phone."""
    context = chromium.new_context(viewport={"width": 375, "height": 800}, is_mobile=True)
    yield Visitor(context.new_page(), service.url)
    context.close()


@pytest.fixture(scope="session")
def finished(chromium: Browser, service: Service) -> tuple[int, Any]:
    """A public run that has finished, and the cookies of its owner."""
    context = chromium.new_context()
    visitor = Visitor(context.new_page(), service.url)
    visitor.sign_up("player")
    run = {"benchmark": "currents-v1", "controller": "p", "config": SHORT, "seed": 3}
    run_id = visitor.submit(run)
    visitor.open(f"/runs/{run_id}")
    visitor.wait_for("succeeded")
    visitor.publish()
    expect(visitor.page.get_by_text("The run is now public")).to_be_visible(timeout=RUN_MS)
    return run_id, context.storage_state()
