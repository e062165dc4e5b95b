"""The first hour on a slow machine: `./run slow-start [SHARE]` (root, because of the CPU quota).

Starts the service with an empty data folder and nothing compiled, on SHARE of each core (default a
twentieth), and does what a newcomer does in Chromium, whose scripts are slowed down as much. Prints
when what had happened, and what the status page said. At a twentieth it takes most of an hour.
"""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from urllib.error import URLError
from urllib.request import urlopen

from playwright.sync_api import Page

from performance.service.web.browser import chromium

SHARE = 0.05
PERIOD_US = 100_000  # the default of both versions of cgroups
CGROUPS = Path("/sys/fs/cgroup")
NAME = f"seamark-slow-{os.getpid()}"
NEVER_MS = 7_200_000  # Playwright's limits; a person waits, too
POLL_S = 5.0
ENDED = ("succeeded", "failed", "cancelled")
MOVES = """() => {
  const clock = document.querySelector("[data-scene] [data-clock]");
  window.seen ??= new Set();
  if (clock?.textContent) window.seen.add(clock.textContent);
  return window.seen.size > 1;
}"""


class Journey:
    """Prints what happens with the seconds since the start of the service."""

    def __init__(self) -> None:
        self._began = time.monotonic()
        self._states: dict[str, str] = {}

    def note(self, what: str) -> None:
        """Print what has happened now."""
        print(f"{time.monotonic() - self._began:6.0f} s  {what}", flush=True)

    def note_state(self, subject: str, state: str) -> None:
        """Print a state, unless it is that of before."""
        if self._states.get(subject) != state:
            self._states[subject] = state
            self.note(f"{subject}: {state}")


def main(arguments: Sequence[str]) -> int:
    """Print the journey."""
    share = float(arguments[0]) if arguments else SHARE
    with tempfile.TemporaryDirectory(prefix="seamark-slow-") as folder, limited(share) as joined:
        data = Path(folder)
        journey, ready = Journey(), data / "ready"
        print(f"With {share:.0%} of each of {len(os.sched_getaffinity(0))} cores:", flush=True)
        command = [sys.executable, "-m", "seamark.cli.main", "up", "--port", "0"]
        command += ["--data", str(data / "data"), "--ready-file", str(ready)]
        service = subprocess.Popen(
            ["/bin/sh", "-c", f'echo $$ > {joined} && exec "$@"', "sh", *command],
            env=os.environ | {"NUMBA_CACHE_DIR": str(data / "compiled")},
            stdout=subprocess.DEVNULL,
        )
        try:
            while not (ready.exists() and ready.read_text()):
                time.sleep(0.5)
            journey.note("the pages are up")
            visit(ready.read_text().strip(), journey, slower=1.0 / share)
        finally:
            service.terminate()
            service.wait()
    return 0


@contextmanager
def limited(share: float) -> Iterator[Path]:
    """Give the file through which a process joins a group with `share` of each core."""
    quota_us = round(share * PERIOD_US * len(os.sched_getaffinity(0)))
    if (CGROUPS / "cgroup.controllers").exists():  # version 2
        (CGROUPS / "cgroup.subtree_control").write_text("+cpu")
        group, files = CGROUPS / NAME, {"cpu.max": f"{quota_us} {PERIOD_US}"}
    else:
        group, files = CGROUPS / "cpu" / NAME, {"cpu.cfs_quota_us": str(quota_us)}
    group.mkdir()
    for name, value in files.items():
        (group / name).write_text(value)
    try:
        yield group / "cgroup.procs"
    finally:
        with suppress(OSError):  # what is left of the service keeps it
            group.rmdir()


def visit(address: str, journey: Journey, *, slower: float) -> None:
    """Do what a newcomer does, from the first picture to the first own result."""
    with chromium() as browser:
        page = browser.new_page(viewport={"width": 1280, "height": 900})
        page.set_default_timeout(NEVER_MS)
        throttle = page.context.new_cdp_session(page)
        throttle.send("Emulation.setCPUThrottlingRate", {"rate": slower})
        page.goto(address, wait_until="commit")
        page.locator(".stage img, .stage canvas").first.wait_for()
        journey.note("the home page shows the first picture")
        page.wait_for_function(MOVES)
        journey.note("the player of the home page moves")
        _write_first_controller(page, journey)
        while not _has_ended(page, address, journey):
            time.sleep(POLL_S)


def _write_first_controller(page: Page, journey: Journey) -> None:
    page.get_by_role("link", name="Write your first controller").first.click()
    page.get_by_role("link", name="Create an account to run it").click()
    page.get_by_label("Name").fill("ada")
    page.get_by_label("Password").fill("correct horse battery")
    page.get_by_role("main").get_by_role("button", name="Create account").click()
    journey.note("an account is created")
    page.get_by_role("button", name="Run it").click()
    page.wait_for_url("**/runs/*")
    journey.note("the first own program is submitted")


def _has_ended(page: Page, address: str, journey: Journey) -> bool:
    """Note what the status page and the page of the run say; return whether the run has ended."""
    with suppress(URLError, TimeoutError):
        status = _read(f"{address.rstrip('/')}/status").partition("<strong>")[2]
        journey.note_state("status page", status.partition("</strong>")[0])
    state = page.locator("[data-state-badge]").inner_text().strip()
    journey.note_state("own run", state)
    return state in ENDED


def _read(url: str) -> str:
    with urlopen(url, timeout=600) as answer:  # noqa: S310 - our own
        text: str = answer.read().decode()
        return text
