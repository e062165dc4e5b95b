"""The real service, started as a user starts it, in a temporary folder."""

import contextlib
import os
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from playwright.sync_api import Browser, sync_playwright

from tests.journey.visitor import Visitor

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
START_S = 90.0
ROOT = Path(__file__).parents[2]


@dataclass(frozen=True)
class Service:
    """A running service."""

    url: str
    data: Path


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def _answers(url: str) -> bool:
    try:
        with urllib.request.urlopen(f"{url}/readyz", timeout=2) as answer:  # noqa: S310 - our own
            return bool(answer.status == 200)
    except (urllib.error.URLError, OSError):
        return False


def _wait(process: "subprocess.Popen[bytes]", url: str, log: Path) -> None:
    give_up = time.monotonic() + START_S
    while not _answers(url):
        if process.poll() is not None or time.monotonic() > give_up:
            pytest.fail(f"the service did not come up:\n{log.read_text()[-4000:]}")
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(0.2)  # wakes up at once when the service ends


@contextlib.contextmanager
def running(**settings: str) -> Iterator[Service]:
    """Start `seamark up` on a free port; one hidden seed, so that a ranked run is short."""
    with tempfile.TemporaryDirectory(prefix="seamark-journey-") as folder:
        port, data, log = _free_port(), Path(folder) / "data", Path(folder) / "log"
        command = [sys.executable, "-m", "seamark.cli.main", "up", "--port", str(port)]
        with log.open("wb") as output:
            process = subprocess.Popen(
                [*command, "--data", str(data)],
                cwd=ROOT,
                env={**os.environ, "SEAMARK_RANKED_TRIALS": "1", **settings},
                stdout=output,
                stderr=subprocess.STDOUT,
            )
        try:
            url = f"http://127.0.0.1:{port}"
            _wait(process, url, log)
            yield Service(url, data)
        finally:
            process.terminate()
            try:
                process.wait(30)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


@pytest.fixture(scope="session")
def service() -> Iterator[Service]:
    """Give the service with its embedded default: SQLite and a broker of its own."""
    with running() as embedded:
        yield embedded


@pytest.fixture
def production(postgres_url: str, redis_tcp_url: str) -> Iterator[Service]:
    """Give the same service on PostgreSQL and a broker over TCP, by settings alone."""
    variables = {"SEAMARK_DATABASE_URL": postgres_url, "SEAMARK_BROKER_URL": redis_tcp_url}
    with running(**variables) as started:
        yield started


@pytest.fixture(scope="session")
def chromium() -> Iterator[Browser]:
    """Give the system's Chromium without a window."""
    if CHROMIUM is None:
        pytest.skip("chromium is not installed (Debian: apt-get install chromium)")
    quiet = ["--disable-background-networking", "--disable-component-update", "--no-first-run"]
    if os.geteuid() == 0:
        quiet.append("--no-sandbox")  # Chromium refuses its own sandbox as root
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=quiet)
        yield browser
        browser.close()


@pytest.fixture
def visitor(chromium: Browser, service: Service) -> Iterator[Visitor]:
    """Give somebody in front of a large screen."""
    context = chromium.new_context(viewport={"width": 1280, "height": 900})
    yield Visitor(context.new_page(), service.url)
    context.close()


@pytest.fixture
def phone(chromium: Browser, service: Service) -> Iterator[Visitor]:
    """Give somebody with a telephone."""
    context = chromium.new_context(viewport={"width": 375, "height": 800}, is_mobile=True)
    yield Visitor(context.new_page(), service.url)
    context.close()
