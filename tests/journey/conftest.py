"""The real service, and browsers to visit it."""

import asyncio
import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, expect, sync_playwright

from tests.journey.service import (
    TWO_TRIALS,
    Service,
    locked,
    once,
    running,
    shared,
    without_baselines,
)
from tests.journey.visitor import Visitor

# The build without windows takes two thirds of the processor time of the other one.
CHROMIUM = (
    shutil.which("chromium-headless-shell")
    or shutil.which("chromium")
    or shutil.which("chromium-browser")
)
SHORT = {"levels": [0.0, 0.4], "level_duration_s": 20, "settle_s": 2}
TRACKING = {"level_duration_s": 2.0, "turbidity_levels": [0.0, 7.0], "motion_levels": [2.0, 8.0]}
PAGE_MS = 30_000  # most that a page takes to change on a loaded machine; Playwright's own is 5 s
expect.set_options(timeout=PAGE_MS)
# As in a browser that cannot draw 3-D graphics.
NO_WEBGL = """
const ask = HTMLCanvasElement.prototype.getContext;
HTMLCanvasElement.prototype.getContext = function (kind, ...options) {
  return kind.startsWith("webgl") ? null : ask.call(this, kind, ...options);
};
"""
# WebGL without a graphics card.
SOFTWARE_RENDERING = ["--enable-unsafe-swiftshader"]


@pytest.fixture(scope="session")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    """The service that all processes of the tests share."""
    folder = tmp_path_factory.getbasetemp()
    with shared(folder.parent if "PYTEST_XDIST_WORKER" in os.environ else folder) as embedded:
        yield embedded


@pytest.fixture
def production(postgres_url: str, redis_tcp_url: str) -> Iterator[Service]:
    """The same service on PostgreSQL and a broker over TCP, by settings alone."""
    variables = {
        "PYTHONPATH": str(TWO_TRIALS),
        "SEAMARK_DATABASE_URL": postgres_url,
        "SEAMARK_BROKER_URL": redis_tcp_url,
        "SEAMARK_WORKERS": "1",  # for its one run; a second would prepare itself for nothing
    }
    with running(**variables) as started:
        without_baselines(postgres_url)
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


# One page for all visitors: a fresh one starts a process, which compiles all scripts anew; a third
# of the time of a visit.
@pytest.fixture(scope="session")
def _desktop(chromium: Browser, service: Service) -> Visitor:
    context = chromium.new_context(viewport={"width": 1280, "height": 900})
    return Visitor(context.new_page(), service.url)


@pytest.fixture(scope="session")
def _reader(chromium: Browser, service: Service) -> Visitor:
    context = chromium.new_context(viewport={"width": 1280, "height": 900})
    context.add_init_script(NO_WEBGL)
    return Visitor(context.new_page(), service.url)


@pytest.fixture(scope="session")
def _phone(chromium: Browser, service: Service) -> Visitor:
    context = chromium.new_context(viewport={"width": 375, "height": 800}, is_mobile=True)
    return Visitor(context.new_page(), service.url)


@pytest.fixture
def visitor(_desktop: Visitor) -> Iterator[Visitor]:
    """A visitor with a desktop screen."""
    yield _desktop
    _desktop.leave()


@pytest.fixture
def reader(_reader: Visitor) -> Iterator[Visitor]:
    """A visitor whose browser has no WebGL, for tests that are not about the scene of a run.

    Without a graphics card the processor draws that, again and again while the run goes on.
    """
    yield _reader
    _reader.leave()


@pytest.fixture
def phone(_phone: Visitor) -> Iterator[Visitor]:
    """A visitor with a phone."""
    yield _phone
    _phone.leave()


@pytest.fixture(scope="session")
def finished(chromium: Browser, service: Service) -> tuple[int, Any]:
    """A public run that has finished, and the cookies of its owner."""
    folder = Path(service.folder)
    with locked(folder):
        run_id, cookies = once(folder / "finished.json", lambda: _finish(chromium, service))
    return run_id, cookies


def _finish(chromium: Browser, service: Service) -> tuple[int, Any]:
    context = chromium.new_context()
    visitor = Visitor(context.new_page(), service.url)
    visitor.sign_up("player")
    run = {"benchmark": "currents-v1", "controller": "p", "config": SHORT, "seed": 3}
    run_id = visitor.submit(run)
    visitor.wait_elsewhere(run_id)
    visitor.publish_unseen(run_id)
    cookies = context.storage_state()
    context.close()
    return run_id, cookies
