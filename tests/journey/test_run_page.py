"""The page of a run while it runs and afterwards: data, camera, tables of a grid."""

import re
from typing import Any

import pytest
from playwright.sync_api import Page, expect

from tests.journey.visitor import LONG, Visitor

pytestmark = [pytest.mark.browser, pytest.mark.host, pytest.mark.slow]

GRID = {
    **{"levels": [0.0, 0.1], "level_duration_s": 4, "settle_s": 1},
    **{"loop1": "turbidity", "loop1_values": [0.0, 0.5, 1.0]},
    **{"loop2": "altitude", "loop2_values": [1.5, 2.0, 2.5]},
}
_PIXELS = """(image) => {
  const canvas = document.createElement("canvas");
  canvas.width = image.naturalWidth;
  canvas.height = image.naturalHeight;
  canvas.getContext("2d").drawImage(image, 0, 0);
  return canvas.toDataURL();
}"""
# Whether the page comes to rest: for so long, none of its scripts asks for a frame.
_RESTS = """() => new Promise((done) => {
  const ask = window.requestAnimationFrame;
  const rested = () => setTimeout(() => done(true), 700);
  let timer = rested();
  window.requestAnimationFrame = (draw) => {
    clearTimeout(timer);
    timer = rested();
    return ask(draw);
  };
  setTimeout(() => done(false), 10_000);
})"""


def _start(visitor: Visitor, config: dict[str, Any], benchmark: str = "currents-v1") -> None:
    """Submit a run through the API and open its page."""
    run = {"benchmark": benchmark, "controller": "p", "config": config, "seed": 3}
    visitor.open(f"/runs/{visitor.submit(run)}")


def _seek(page: Page, seconds: float) -> str:
    """Move the slider and return the camera image that it shows."""
    page.locator("[data-time]").fill(str(seconds))
    expect(page.locator("[data-camera] img")).to_have_attribute(
        "src", re.compile(f"t={seconds:.2f}$")
    )
    pixels: str = page.locator("[data-camera] img").evaluate(_PIXELS)
    return pixels


def test_telemetry_can_be_downloaded_while_the_run_is_running(reader: Visitor) -> None:
    page = reader.page
    _start(reader, LONG)
    expect(page.locator("[data-camera] img")).to_be_visible(timeout=60_000)

    with page.expect_download() as download:
        page.get_by_role("link", name="telemetry.csv").click()
    reader.wait_for("running")
    reader.press_and_confirm("Cancel")
    reader.wait_for("cancelled")

    lines = download.value.path().read_text().splitlines()
    rows = [line for line in lines if not line.startswith("#")]
    assert any("state running" in line for line in lines[:10])
    assert 1 < len(rows) < 1 + 12 * 600 * 20
    assert (reader.errors, reader.violations()) == ([], [])


def test_the_slider_and_the_play_button_change_the_camera_image(
    visitor: Visitor, finished: tuple[int, Any]
) -> None:
    page = visitor.page
    visitor.open(f"/runs/{finished[0]}")

    early, late = _seek(page, 1.0), _seek(page, 39.0)
    again = _seek(page, 1.0)
    page.get_by_role("button", name="Play").click()
    expect(page.locator("[data-clock]")).to_contain_text(re.compile(r"^[2-9]\.\d\d s"))
    page.get_by_role("button", name="Pause").click()

    assert page.evaluate(_RESTS)
    assert early == again
    assert early != late
    assert (visitor.errors, visitor.violations()) == ([], [])


def test_the_page_names_the_level_that_ran_where_the_order_is_drawn(reader: Visitor) -> None:
    page = reader.page
    levels = [0.1, 0.2, 0.3]
    _start(
        reader,
        {"levels": levels, "level_duration_s": 4, "settle_s": 1},
        benchmark="currents-v2",
    )
    reader.wait_for("succeeded")
    metrics = page.request.get(f"{reader.url}/api/v1{page.url.removeprefix(reader.url)}").json()
    (trial,) = metrics["metrics"]["trials"]
    order = trial["conditions"]["order"]

    shown = []
    for position in range(len(levels)):
        _seek(page, 4.0 * position + 2.0)
        shown.append(page.locator("[data-clock]").inner_text().split()[-2])

    assert order != sorted(order)
    assert shown == [f"{levels[level]:g}" for level in order]
    assert (reader.errors, reader.violations()) == ([], [])


def test_the_wide_tables_of_a_grid_scroll_inside_their_own_box_on_a_phone(phone: Visitor) -> None:
    page = phone.page
    run = {"benchmark": "currents-v1", "controller": "p", "trials": 2, "config": GRID, "seed": 3}
    number = phone.submit(run)
    phone.wait_elsewhere(number)
    phone.open(f"/runs/{number}")
    page.locator("table.metrics.tall").first.wait_for()

    page.evaluate("for (const part of document.querySelectorAll('details')) part.open = true")

    whole = page.evaluate("document.documentElement.scrollWidth")
    boxes = page.locator(".table-wrap").evaluate_all(
        "boxes => boxes.map((box) => [box.scrollWidth > box.clientWidth, box.tabIndex])"
    )
    assert whole <= 375
    assert [True, 0] in boxes
    assert (phone.errors, phone.violations()) == ([], [])
