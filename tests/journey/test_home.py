"""The home page: what plays there without being asked, and what does not."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, expect

from tests.journey.service import Service

pytestmark = [pytest.mark.browser, pytest.mark.host, pytest.mark.slow]

# The browser of the tests draws by the processor; this is what it says with a graphics card.
GRAPHICS_CARD = """
for (const context of [WebGLRenderingContext, WebGL2RenderingContext]) {
  const asked = context.prototype.getParameter;
  context.prototype.getParameter = function (name) {
    return name === 0x9246 ? "A graphics card" : asked.call(this, name);
  };
}
"""
START = re.compile(r"^40\.00 s$")  # of the replay


@contextmanager
def _home(
    chromium: Browser, service: Service, script: str = "", motion: str = ""
) -> Iterator[Page]:
    options: Any = {"reduced_motion": motion} if motion else {}
    context = chromium.new_context(**options)
    context.add_init_script(script)
    page = context.new_page()
    page.goto(service.url)
    expect(page.locator(".stage canvas")).to_be_visible()
    yield page
    context.close()


def test_the_replay_plays_unasked_with_a_graphics_card(chromium: Browser, service: Service) -> None:
    with _home(chromium, service, GRAPHICS_CARD) as page:
        expect(page.get_by_role("button", name="Pause")).to_be_visible()
        expect(page.locator("[data-clock]")).not_to_have_text(START)


@pytest.mark.parametrize(("script", "motion"), [("", ""), (GRAPHICS_CARD, "reduce")])
def test_the_replay_waits_where_the_processor_draws_and_where_motion_is_unwanted(
    chromium: Browser, service: Service, script: str, motion: str
) -> None:
    with _home(chromium, service, script, motion) as page:
        play, clock = page.get_by_role("button", name="Play"), page.locator("[data-clock]")
        expect(play).to_be_visible()
        page.wait_for_timeout(500)
        expect(clock).to_have_text(START)

        play.click()

        expect(clock).not_to_have_text(START)
