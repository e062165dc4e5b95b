"""The player where it is not on its own page, or cannot draw its scene."""

import re
import threading
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

import pytest
from playwright.sync_api import Browser, expect

from tests.journey.service import Service
from tests.journey.visitor import Visitor

pytestmark = [pytest.mark.browser, pytest.mark.host, pytest.mark.slow]

SCENE_MS = 60_000  # three.js and a first picture, on a machine with other work


@pytest.fixture
def other_site(service: Service) -> Iterator[int]:
    """The port of another web server; its page shows the run that its query names in a frame."""

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            source = f"{service.url}/runs/{self.path.partition('?')[2]}/embed"
            frame = f'<iframe title="run" width="900" height="700" src="{source}"></iframe>'
            self.send_response(200)
            self.send_header("Content-Type", "text/html")
            self.end_headers()
            self.wfile.write(f"<!doctype html>{frame}".encode())

        def log_message(self, *_: object) -> None:
            """Say nothing."""

    server = ThreadingHTTPServer(("127.0.0.1", service.embedding_port), Handler)
    thread = threading.Thread(target=server.serve_forever, args=(0.02,))
    thread.start()
    yield service.embedding_port
    server.shutdown()
    thread.join()
    server.server_close()


def test_a_site_that_the_operator_allows_shows_the_player_in_a_frame_and_others_do_not(
    chromium: Browser, other_site: int, finished: tuple[int, Any]
) -> None:
    page = chromium.new_context().new_page()
    frame = page.frame_locator("iframe")

    page.goto(f"http://localhost:{other_site}/?{finished[0]}")
    expect(frame.locator("[data-pose]")).to_contain_text("north", timeout=SCENE_MS)
    frame.locator("[data-time]").fill("25")
    expect(frame.locator("[data-clock]")).to_contain_text("25.00 s, current 0.4 m/s")
    with page.expect_console_message(lambda message: "frame-ancestors" in message.text):
        page.goto(f"http://127.0.0.1:{other_site}/?{finished[0]}")

    expect(frame.locator("[data-player]")).to_have_count(0)
    page.context.close()


def test_without_webgl_a_picture_and_a_sentence_stand_for_the_scene(
    reader: Visitor, finished: tuple[int, Any]
) -> None:
    page = reader.page
    reader.open(f"/runs/{finished[0]}")

    expect(page.get_by_text("cannot draw 3-D graphics")).to_be_visible(timeout=SCENE_MS)
    page.locator("[data-time]").fill("30")
    expect(page.locator("[data-camera] img")).to_have_attribute("src", re.compile(r"t=30\.00$"))
    expect(page.locator("[data-clock]")).to_contain_text("30.00 s")
    assert reader.errors == []
