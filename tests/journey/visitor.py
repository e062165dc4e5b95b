"""A visitor of the pages in a real browser."""

import re
import time
from typing import Any

from playwright.sync_api import APIResponse, FilePayload, Locator, Page, expect

RUN_MS = 120_000
PHONE_PX = 375
# One trial that takes a core a dozen seconds, so that a browser is done first; more trials would
# take more cores from it.
LONG = {"levels": [0.03 * level for level in range(12)], "level_duration_s": 600}
PASSWORD = "correct horse battery"
PROGRAM = """
class Controller:
    def __init__(self, config):
        self.kp = config["kp"]

    def reset(self, level):
        print("level", level["index"])

    def step(self, observation):
        x, y, _ = observation.error
        return [self.kp * x, self.kp * y, 0.0, 0.0]
"""
# Collects violations of the content security policy.
_COLLECT = """
window.violations = [];
document.addEventListener("securitypolicyviolation", (event) => {
  window.violations.push(`${event.violatedDirective} ${event.blockedURI} ${event.sourceFile}`);
});
"""


class Visitor:
    """Uses the pages as a person would, and collects the errors of their scripts."""

    def __init__(self, page: Page, url: str) -> None:
        self.page, self.url = page, url
        self.errors: list[str] = []
        self._size: Any = page.viewport_size
        page.add_init_script(_COLLECT)
        page.on("pageerror", lambda error: self.errors.append(f"{page.url}: {error}"))
        page.on("console", self._on_console)

    def _on_console(self, message: object) -> None:
        if getattr(message, "type", "") == "error":
            self.errors.append(f"{self.page.url}: {getattr(message, 'text', '')}")

    def leave(self) -> None:
        """Leave nothing for the next visitor who uses this page but what the browser has cached."""
        self.page.unroute_all()
        if self.page.viewport_size != self._size:
            self.page.set_viewport_size(self._size)
        self.rest()
        self.page.evaluate("localStorage.clear(); sessionStorage.clear()")
        self.page.context.clear_cookies()
        self.errors.clear()

    def rest(self) -> None:
        """Leave a page for one that draws nothing; a blank one would end the renderer's process."""
        self.open("/static/logo.svg")

    def open(self, path: str) -> None:
        self.page.goto(self.url + path)

    def sign_up(self, name: str) -> None:
        """Create an account without its pages: the one that follows draws a scene."""
        address = f"{self.url}/sign-up"
        token = re.search(r'name="csrf_token" value="([^"]+)"', self._get(address).text())
        assert token is not None
        account = {"csrf_token": token[1], "name": name, "password": PASSWORD}
        answer = self.page.request.post(address, form=account)
        expect(answer).to_be_ok()
        assert f"Welcome, {name}." in answer.text()

    def sign_in(self, name: str) -> None:
        self.open("/sign-in")
        self.page.get_by_label("Name").fill(name)
        self.page.get_by_label("Password").fill(PASSWORD)
        self.page.get_by_role("main").get_by_role("button", name="Sign in").click()
        expect(self.page.get_by_role("link", name=name, exact=True)).to_be_visible()

    def fill_in_account(self, name: str) -> None:
        self.page.get_by_label("Name").fill(name)
        self.page.get_by_label("Password").fill(PASSWORD)
        self.page.get_by_role("button", name="Create account").click()
        expect(self.page.get_by_text(f"Welcome, {name}.")).to_be_visible(timeout=RUN_MS)

    def submit(self, run: dict[str, Any]) -> int:
        """Queue a run through the API and return its number."""
        number: int = self._post("/runs", run).json()["id"]
        return number

    def publish_unseen(self, run_id: int) -> None:
        """Publish a run through the API, without its page."""
        self._post(f"/runs/{run_id}/publish", {"method": "Steady hand"})

    def cancel_unseen(self) -> None:
        """Cancel the run of this page through the API, before the page could do it."""
        path = self.page.url.partition("#")[0].removeprefix(self.url)
        self._post(f"{path}/cancel", {})

    def _get(self, address: str) -> APIResponse:
        answer = self.page.request.get(address)
        expect(answer).to_be_ok()
        return answer

    def _post(self, path: str, data: dict[str, Any]) -> APIResponse:
        """Ask the API as the scripts of a page do."""
        api = f"{self.url}/api/v1"
        token = self._get(f"{api}/me").json()["csrf_token"] or ""
        answer = self.page.request.post(f"{api}{path}", data=data, headers={"X-CSRFToken": token})
        expect(answer).to_be_ok()
        return answer

    def press_and_confirm(self, name: str) -> None:
        """Press a button that asks first, and the one of the same name in the dialog.

        On the page of a run, most of them are in a menu.
        """
        unfold = "for (const menu of document.querySelectorAll('.menu')) menu.open = true"
        self.page.evaluate(unfold)
        self.page.get_by_role("button", name=name).click()
        self.page.get_by_role("dialog").get_by_role("button", name=name).click()

    def publish(self) -> None:
        """Publish the run of this page, with its program and by name."""
        self.page.get_by_role("link", name="Publish …").click()
        self.page.get_by_label("Name of the method").fill("Steady hand")
        self.page.get_by_role("button", name="Publish").click()

    def tab_to(self, control: Locator, most: int = 12) -> None:
        """Move the focus to a control with the Tab key."""
        for _ in range(most):
            self.page.keyboard.press("Tab")
            if control.evaluate("one => one.getRootNode().activeElement === one"):
                return
        expect(control).to_be_focused()

    def wait_for(self, state: str, *, timeout_ms: float = RUN_MS) -> None:
        badge = self.page.locator("[data-state-badge] .badge")
        expect(badge).to_have_text(re.compile(state), timeout=timeout_ms)

    def wait_elsewhere(self, run_id: int, *, timeout_ms: float = RUN_MS) -> None:
        """Wait for the success of a run without its page, which takes a browser's time to draw."""
        deadline = time.monotonic() + timeout_ms / 1000
        state = "queued"
        while state in ("queued", "running"):
            assert time.monotonic() < deadline
            self.page.wait_for_timeout(500)
            state = self.page.request.get(f"{self.url}/api/v1/runs/{run_id}").json()["state"]
        assert state == "succeeded"

    def violations(self) -> list[str]:
        found: list[str] = self.page.evaluate("window.violations")
        return found


def width_on_a_phone(page: Page) -> int:
    """Return how wide a page is in a window as wide as a phone [px].

    Charts follow the size of the window a frame later, on a busy machine much later.
    """
    page.set_viewport_size({"width": PHONE_PX, "height": 800})
    width = 0
    for _ in range(50):
        width = page.evaluate("document.documentElement.scrollWidth")
        if width <= PHONE_PX:
            break
        page.wait_for_timeout(100)
    return width


def customise(page: Page, group: str = "") -> None:
    """Unfold the settings of the form, and one of their groups."""
    settings = page.locator("#customise")
    _unfold(settings)
    if group:
        _unfold(settings.locator(f"details.group:has(> summary:has-text('{group}'))").first)


def _unfold(details: Locator) -> None:
    details.evaluate("one => { one.open = true; one.classList.remove('partial'); }")


def editor_of(page: Page) -> Locator:
    """Return the editor that takes the place of the text area."""
    return page.locator(".cm-content[aria-label='Your program']")


def write_program(page: Page, text: str) -> None:
    """Choose one's own program and replace its text in the editor."""
    page.locator("label", has_text="My own program").click()
    replace_program(page, text)


def replace_program(page: Page, text: str) -> None:
    """Replace the text of the editor as somebody who pastes."""
    editor_of(page).focus()  # not fill(): its command inserts inline styles
    page.keyboard.press("Control+a")
    page.keyboard.insert_text(text)


def choose_file(page: Page, file: FilePayload) -> None:
    """Choose a file as one's own program."""
    page.locator("label", has_text="My own program").click()
    page.locator("label", has_text="Upload a file").click()
    page.locator("#program").set_input_files(file)


def shorten(page: Page) -> None:
    """Fill in an experiment of a few seconds."""
    customise(page, "Experiment")
    page.get_by_label("Current levels").fill("0, 0.1")
    page.get_by_label("Level duration").fill("4")
    page.get_by_label("Settle window").fill("1")
