"""The player of a run: scene, camera, numbers and charts on one time line."""

import math
import re
import threading
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Browser, Page, expect

from tests.journey.conftest import EMBEDDING_PORT, Service
from tests.journey.visitor import RUN_MS, Visitor

pytestmark = [pytest.mark.browser, pytest.mark.host, pytest.mark.slow]

LONG = {"levels": [0.0, 0.1, 0.2, 0.3], "level_duration_s": 600}
SCENE_MS = 60_000  # three.js and a first picture, on a machine with other work


def _open(visitor: Visitor, path: str) -> Page:
    """Open a page with the scene in sight and wait for its first picture."""
    visitor.open(path)
    visitor.page.locator("[data-stage]").scroll_into_view_if_needed()
    expect(visitor.page.locator("[data-pose]")).to_contain_text("north", timeout=SCENE_MS)
    return visitor.page


def _time(page: Page) -> float:
    return float(page.locator("[data-time]").input_value())


def _rows(page: Page, url: str, run_id: int, t: float) -> dict[str, float]:
    """Return the row of the telemetry at time `t`."""
    columns = "x,y,z,yaw,distance,level"
    query = f"columns={columns}&sample=rows&start={t}&stop={t}"
    found = page.request.get(f"{url}/api/v1/runs/{run_id}/series.json?{query}").json()
    return {name: values[0] for name, values in found["columns"].items()}


def _pose_in_words(row: dict[str, float]) -> str:
    """Return what the scene says of its vehicle at a row."""
    x, y, z = (f"{row[name]:.3f}".replace("-", "−") for name in "xyz")
    heading = math.degrees(row["yaw"]) % 360
    return f"north {x}, east {y}, depth {z} m, heading {heading:.1f}°"


def test_at_every_time_the_vehicle_of_the_scene_has_the_pose_of_the_telemetry(
    visitor: Visitor, finished: tuple[int, Any]
) -> None:
    run_id, _ = finished
    page = _open(visitor, f"/runs/{run_id}")

    for t in (0.0, 13.35, 20.0, 37.8):
        page.locator("[data-time]").fill(str(t))
        row = _rows(page, visitor.url, run_id, t)
        expect(page.locator("[data-pose]")).to_have_text(_pose_in_words(row), timeout=SCENE_MS)
        expect(page.locator("[data-numbers]")).to_contain_text(f"{row['distance']:.3f} m")

    assert (visitor.errors, visitor.violations()) == ([], [])


def test_jumps_lead_to_levels_and_to_the_largest_error(
    visitor: Visitor, finished: tuple[int, Any]
) -> None:
    run_id, _ = finished
    page = _open(visitor, f"/runs/{run_id}")
    found = page.request.get(f"{visitor.url}/api/v1/runs/{run_id}/moments.json").json()
    jump, slider = page.get_by_label("Jump to"), page.locator("[data-time]")

    jump.select_option("Next level")
    expect(slider).to_have_value("20")
    jump.select_option("Largest error")
    expect(slider).to_have_value(f"{found['largest_error']['t']:g}")
    jump.select_option("Previous level")
    expect(slider).to_have_value("20")
    jump.select_option("Target first lost")
    expect(page.locator("[data-jump-note]")).to_have_text("The target was never lost.")

    assert [level["t"] for level in found["levels"]] == [0.0, 20.0]


def test_a_reload_resumes_time_view_and_charts(visitor: Visitor, finished: tuple[int, Any]) -> None:
    run_id, _ = finished
    page = _open(visitor, f"/runs/{run_id}#t=12.5")
    expect(page.locator("[data-time]")).to_have_value("12.5")
    page.get_by_role("radio", name="Top").check()
    page.get_by_text("Choose charts").click()
    page.get_by_role("checkbox", name="thrust_0").check()
    page.get_by_role("checkbox", name="thrust_1").check()
    page.get_by_role("button", name="Add chart").click()
    expect(page.get_by_role("img", name=re.compile("thrust_0, thrust_1"))).to_be_visible()
    page.locator("[data-time]").fill("31.25")

    page.reload()

    expect(page.locator("[data-time]")).to_have_value("31.25")
    expect(page.get_by_role("radio", name="Top")).to_be_checked()
    expect(page.get_by_role("img", name=re.compile("thrust_0, thrust_1"))).to_be_visible()
    assert (visitor.errors, visitor.violations()) == ([], [])


def test_the_player_works_by_keyboard_alone(visitor: Visitor, finished: tuple[int, Any]) -> None:
    run_id, _ = finished
    page = _open(visitor, f"/runs/{run_id}")
    slider, stage = page.locator("[data-time]"), page.locator("[data-stage]")

    page.keyboard.press("k")
    expect(page.get_by_role("button", name="Pause")).to_be_visible()
    page.keyboard.press("k")
    page.keyboard.press("Home")
    page.keyboard.press("l")
    page.keyboard.press("ArrowRight")
    page.keyboard.press(".")
    expect(slider).to_have_value("11.05")
    page.keyboard.press("End")
    expect(slider).to_have_value("39.95")

    page.locator("[data-stage] canvas").focus()
    before = stage.get_attribute("data-pictures")
    page.keyboard.press("ArrowLeft")
    expect(stage).not_to_have_attribute("data-pictures", str(before))
    expect(slider).to_have_value("39.95")  # the arrow turned the view


def test_a_live_run_is_followed_then_watched_behind_its_newest_data_with_the_same_images(
    visitor: Visitor,
) -> None:
    page = visitor.page
    run = {"benchmark": "currents-v1", "controller": "p", "trials": 10, "config": LONG, "seed": 3}
    answer = page.request.post(f"{visitor.url}/api/v1/runs", data=run)
    visitor.open(f"/runs/{answer.json()['id']}")
    live = page.get_by_role("button", name="Live", exact=True)
    expect(page.locator("[data-camera] img")).to_be_visible(timeout=RUN_MS)
    expect(live).to_have_attribute("aria-pressed", "true")

    page.get_by_role("button", name="Pause").click()
    t, image = _time(page), page.locator("[data-camera] img")
    expect(image).to_have_attribute("src", re.compile(rf"t={t:.2f}$"))
    address = str(image.get_attribute("src"))
    while_running = page.request.get(address).body()
    page.get_by_role("button", name="Play").click()
    expect(page.locator("[data-time]")).not_to_have_value(f"{t:g}")
    expect(live).to_have_attribute("aria-pressed", "false")
    live.click()
    expect(live).to_have_attribute("aria-pressed", "true")
    while _time(page) <= t + 5:
        page.wait_for_timeout(100)
    visitor.press_and_confirm("Cancel")
    visitor.wait_for("cancelled")

    page.locator("[data-time]").fill(str(t))
    expect(image).to_have_attribute("src", re.compile(rf"t={t:.2f}$"))
    assert page.request.get(address).body() == while_running
    assert (visitor.errors, visitor.violations()) == ([], [])


@pytest.fixture
def other_site(service: Service) -> Iterator[None]:
    """Another web server; its page shows the run that its query names in a frame."""

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

    server = ThreadingHTTPServer(("127.0.0.1", EMBEDDING_PORT), Handler)
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    yield
    server.shutdown()
    thread.join()
    server.server_close()


def test_a_site_that_the_operator_allows_shows_the_player_in_a_frame_and_others_do_not(
    chromium: Browser, other_site: None, finished: tuple[int, Any]
) -> None:
    page = chromium.new_context().new_page()
    frame = page.frame_locator("iframe")

    page.goto(f"http://localhost:{EMBEDDING_PORT}/?{finished[0]}")
    expect(frame.locator("[data-pose]")).to_contain_text("north", timeout=SCENE_MS)
    frame.locator("[data-time]").fill("25")
    expect(frame.locator("[data-clock]")).to_contain_text("25.00 s, current 0.4 m/s")
    with page.expect_console_message(lambda message: "frame-ancestors" in message.text):
        page.goto(f"http://127.0.0.1:{EMBEDDING_PORT}/?{finished[0]}")

    expect(frame.locator("[data-player]")).to_have_count(0)
    page.context.close()


def test_without_webgl_a_picture_and_a_sentence_stand_for_the_scene(
    service: Service, finished: tuple[int, Any], chromium: Browser
) -> None:
    context = chromium.new_context()
    # As in a browser without WebGL; the rest of the canvas stays.
    context.add_init_script(
        "const get = HTMLCanvasElement.prototype.getContext;"
        "HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {"
        "  return kind.startsWith('webgl') ? null : get.call(this, kind, ...rest); };"
    )
    visitor = Visitor(context.new_page(), service.url)
    visitor.open(f"/runs/{finished[0]}")

    expect(visitor.page.get_by_text("cannot draw 3-D graphics")).to_be_visible(timeout=SCENE_MS)
    visitor.page.locator("[data-time]").fill("30")
    expect(visitor.page.locator("[data-camera] img")).to_have_attribute(
        "src", re.compile(r"t=30\.00$")
    )
    expect(visitor.page.locator("[data-clock]")).to_contain_text("30.00 s")
    assert visitor.errors == []
    context.close()


def test_the_player_fits_a_phone_and_its_bar_stays_in_sight(
    phone: Visitor, finished: tuple[int, Any]
) -> None:
    page = _open(phone, f"/runs/{finished[0]}")

    for anchor in ("#scene-title", "#charts-title", "#metrics-title"):
        page.locator(anchor).scroll_into_view_if_needed()
        expect(page.locator("[data-bar]")).to_be_in_viewport(ratio=0.9)

    assert page.evaluate("document.documentElement.scrollWidth") <= 375


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing_on_the_run_page_and_the_embedded_player(
    chromium: Browser, service: Service, finished: tuple[int, Any], scheme: Any
) -> None:
    context = chromium.new_context(color_scheme=scheme, viewport={"width": 1280, "height": 900})
    visitor = Visitor(context.new_page(), service.url)

    for path in (f"/runs/{finished[0]}", f"/runs/{finished[0]}/embed"):
        visitor.open(path)
        visitor.page.evaluate(
            "for (const part of document.querySelectorAll('details')) part.open = true"
        )
        found = Axe().run(visitor.page)
        assert found.violations_count == 0, f"{path}\n{found.generate_report()}"
    assert visitor.errors == []
    context.close()
