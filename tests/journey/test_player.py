"""The player of a run: scene, camera, numbers and charts on one time line."""

import math
import re
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from playwright.sync_api import Browser, Locator, Page, expect

from tests.journey import accessibility
from tests.journey.service import Service
from tests.journey.visitor import LONG, RUN_MS, Visitor

pytestmark = [pytest.mark.browser, pytest.mark.host, pytest.mark.slow]

SCENE_MS = 60_000  # three.js and a first picture, on a machine with other work


def _open(visitor: Visitor, path: str) -> Page:
    """Open a page with the scene in sight and wait for its first picture."""
    visitor.open(path)
    visitor.page.locator("[data-stage]").scroll_into_view_if_needed()
    expect(visitor.page.locator("[data-pose]")).to_contain_text("north", timeout=SCENE_MS)
    return visitor.page


def _read(reader: Visitor, path: str) -> Page:
    """Open a page without its scene, for a test of what is beside that."""
    reader.open(path)
    expect(reader.page.locator(".chart").first).to_be_visible()
    return reader.page


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


def _contrast(image: bytes, *, share: float = 0.9) -> float:
    """Return the standard deviation of the green channel inside, without the borders."""
    decoded = cv2.imdecode(np.frombuffer(image, np.uint8), cv2.IMREAD_COLOR)
    assert decoded is not None
    height, width = decoded.shape[:2]
    rows = slice(height // 20, -height // 20)
    columns = slice(int(width * (1 - share) / 2), int(width * (1 + share) / 2))
    return float(decoded[rows, columns, 1].astype(np.float64).std())


def _settled(part: Locator) -> bytes:
    """Return the screenshot of a part of the page once it stays as it is."""
    before, now = b"", part.screenshot()
    while now != before:
        part.page.wait_for_timeout(800)  # longer than until a picture that rests has all pixels
        before, now = now, part.screenshot()
    return now


@pytest.fixture(scope="module")
def turbid(chromium: Browser, service: Service, finished: tuple[int, Any]) -> int:
    """A public run whose tracker loses its target, in levels of optical depth 0, 2, 4 and 6."""
    levels = {"sweep_from": 0.0, "sweep_to": 6.0, "sweep_step": 2.0, "level_duration_s": 2.0}
    context = chromium.new_context(storage_state=finished[1])
    visitor = Visitor(context.new_page(), service.url)
    run_id = visitor.submit(
        {"benchmark": "visibility-v1", "controller": "built-in", "config": levels, "seed": 3}
    )
    visitor.wait_elsewhere(run_id)
    visitor.publish_unseen(run_id)
    context.close()
    return run_id


def test_the_scene_from_on_board_is_as_turbid_as_the_cameras_picture(
    visitor: Visitor, turbid: int
) -> None:
    run_id = turbid
    page = _open(visitor, f"/runs/{run_id}")
    stage, pose = page.locator("[data-stage]"), page.locator("[data-pose]")
    page.get_by_role("radio", name="On board").check()
    page.wait_for_load_state("networkidle")  # the textures are there
    stage.evaluate("stage => stage.scrollIntoView({ block: 'center' })")  # not below the bar

    scene, camera = [], []
    for t in (1.0, 3.0, 7.0):
        page.locator("[data-time]").fill(str(t))
        expect(pose).to_have_text(_pose_in_words(_rows(page, visitor.url, run_id, t)))
        expect(stage).to_have_attribute("data-water", f"0:{t // 2:g}", timeout=SCENE_MS)
        picture = f"{visitor.url}/api/v1/runs/{run_id}/camera.jpg?truth=false&tracked=false&t={t}"
        camera.append(_contrast(page.request.get(picture).body()))
        scene.append(_contrast(_settled(stage), share=0.7))
    page.get_by_role("checkbox", name="Turbidity").uncheck()
    clear = _contrast(_settled(stage), share=0.7)

    assert scene[1] / scene[0] == pytest.approx(camera[1] / camera[0], rel=0.3)
    assert scene[2] < 0.05 * scene[0]
    assert clear > 0.7 * scene[0]


def test_losses_and_changes_of_the_level_are_marked_on_the_time_line(
    reader: Visitor, turbid: int
) -> None:
    page = _read(reader, f"/runs/{turbid}")
    found = page.request.get(f"{reader.url}/api/v1/runs/{turbid}/moments.json").json()
    marks = page.locator("[data-marks]")

    expect(marks.locator(".change")).to_have_count(3)
    expect(marks.locator(".loss")).to_have_count(len(found["losses"]))
    first = marks.locator(".loss").first.evaluate("mark => parseFloat(mark.style.left)")

    assert first == pytest.approx(100 * found["losses"][0] / 8.0, abs=0.01)
    expect(page.get_by_text("target lost", exact=True)).to_be_visible()
    expect(page.get_by_text("first touch in a level", exact=True)).to_be_hidden()


def test_the_axis_of_distances_becomes_logarithmic_and_stays_so_after_a_reload(
    reader: Visitor, finished: tuple[int, Any]
) -> None:
    page = _read(reader, f"/runs/{finished[0]}")
    box, axis = page.get_by_label("Logarithmic distances"), page.locator(".chart").first
    linear = _settled(axis)

    box.check()
    logarithmic = _settled(axis)
    page.reload()
    expect(box).to_be_checked()

    assert logarithmic != linear
    assert reader.errors == []


def test_a_picture_and_a_clip_show_scene_camera_and_numbers(
    visitor: Visitor, finished: tuple[int, Any], tmp_path: Path
) -> None:
    page = _open(visitor, f"/runs/{finished[0]}#t=12.5")
    expect(page.locator("[data-camera] img")).to_be_visible()

    page.locator("[data-menu] summary").click()
    with page.expect_download() as saved:
        page.get_by_role("button", name="Save a picture").click()
    picture = cv2.imread(str(saved.value.path()))
    page.keyboard.press("r")
    expect(page.get_by_role("button", name=re.compile("Stop recording, [1-9]"))).to_be_visible()
    with page.expect_download(timeout=RUN_MS) as recorded:
        page.keyboard.press("k")  # to pause ends the clip
    recorded.value.save_as(tmp_path / recorded.value.suggested_filename)
    video = cv2.VideoCapture(str(tmp_path / recorded.value.suggested_filename))

    assert picture is not None
    assert picture.shape == (1080, 1920, 3)
    scene, camera, numbers = picture[:972, :1300], picture[:400, 1330:], picture[500:900, 1330:]
    assert min(part.std() for part in (scene, camera, numbers)) > 5.0
    assert saved.value.suggested_filename == f"seamark-run-{finished[0]}-12.5s.png"
    assert video.read()[1].shape == (720, 1280, 3)
    assert (visitor.errors, visitor.violations()) == ([], [])


def test_the_question_mark_lists_the_shortcuts(visitor: Visitor, finished: tuple[int, Any]) -> None:
    page = _open(visitor, f"/runs/{finished[0]}")

    page.keyboard.press("?")
    expect(page.get_by_role("dialog", name="Keyboard shortcuts")).to_contain_text("Play or pause")
    page.keyboard.press("k")  # not while the list is open
    page.keyboard.press("Escape")
    expect(page.get_by_role("dialog")).to_be_hidden()
    expect(page.get_by_role("button", name="Play", exact=True)).to_be_visible()
    page.keyboard.press("3")
    expect(page.get_by_role("radio", name="Top")).to_be_checked()


def test_jumps_lead_to_levels_and_to_the_largest_error(
    reader: Visitor, finished: tuple[int, Any]
) -> None:
    run_id, _ = finished
    page = _read(reader, f"/runs/{run_id}")
    found = page.request.get(f"{reader.url}/api/v1/runs/{run_id}/moments.json").json()
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


def test_flying_leaves_the_vehicle_and_arrows_show_what_is_out_of_sight(
    visitor: Visitor, finished: tuple[int, Any]
) -> None:
    run_id, _ = finished
    page = _open(visitor, f"/runs/{run_id}#t=30")
    station, vehicle = (page.locator(f"[data-pointer={name}]") for name in ("station", "vehicle"))
    expect(station).to_be_hidden()

    page.get_by_role("radio", name="Free").check()
    page.locator("[data-stage] canvas").focus()
    for _ in range(14):
        page.keyboard.press("ArrowRight")  # looks away
    expect(station).to_contain_text(" m")
    expect(vehicle).to_be_visible()
    page.get_by_role("button", name="Reset the view").click()
    expect(vehicle).to_be_hidden()
    page.locator("[data-stage] canvas").focus()
    page.keyboard.down("w")
    expect(vehicle).to_be_visible(timeout=SCENE_MS)  # behind the eye
    page.keyboard.up("w")

    expect(page.locator("[data-time]")).to_have_value("30")
    assert visitor.errors == []


def test_a_scene_out_of_sight_is_not_drawn_while_the_run_plays_and_goes_on_when_it_is_back(
    visitor: Visitor, finished: tuple[int, Any]
) -> None:
    page = _open(visitor, f"/runs/{finished[0]}")
    stage, pose = page.locator("[data-stage]"), page.locator("[data-pose]")

    page.keyboard.press("k")
    page.get_by_role("contentinfo").scroll_into_view_if_needed()
    expect(stage).not_to_be_in_viewport()
    for _ in range(20):  # the browser says some frames later that it is out of sight
        t, pictures, words = _time(page), stage.get_attribute("data-pictures"), pose.inner_text()
        while _time(page) < t + 0.5:
            page.wait_for_timeout(100)
        if stage.get_attribute("data-pictures") == pictures:
            break
    else:
        pytest.fail("the scene is drawn out of sight")
    expect(pose).not_to_have_text(words)  # a screen reader reads it there
    stage.scroll_into_view_if_needed()

    expect(stage).not_to_have_attribute("data-pictures", str(pictures))
    assert (visitor.errors, visitor.violations()) == ([], [])


def test_a_live_run_is_followed_then_watched_behind_its_newest_data_with_the_same_images(
    reader: Visitor,
) -> None:
    page = reader.page
    run = {"benchmark": "currents-v1", "controller": "p", "config": LONG, "seed": 3}
    answer = page.request.post(f"{reader.url}/api/v1/runs", data=run)
    reader.open(f"/runs/{answer.json()['id']}")
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
    while _time(page) <= t + 2:
        page.wait_for_timeout(100)
    reader.press_and_confirm("Cancel")
    reader.wait_for("cancelled")

    page.locator("[data-time]").fill(str(t))
    expect(image).to_have_attribute("src", re.compile(rf"t={t:.2f}$"))
    assert page.request.get(address).body() == while_running
    assert (reader.errors, reader.violations()) == ([], [])


def test_the_player_fits_a_phone_and_its_bar_stays_in_sight(
    phone: Visitor, finished: tuple[int, Any]
) -> None:
    page = _open(phone, f"/runs/{finished[0]}")

    for anchor in ("#scene-title", "#charts-title", "#metrics-title"):
        page.locator(anchor).scroll_into_view_if_needed()
        expect(page.locator("[data-bar]")).to_be_in_viewport(ratio=0.9)

    assert page.evaluate("document.documentElement.scrollWidth") <= 375


@pytest.mark.parametrize(
    ("scheme", "found"),
    [("light", accessibility.defects), ("dark", partial(accessibility.faint_texts, theme="dark"))],
)
def test_axe_finds_nothing_on_the_run_page_and_the_embedded_player(
    chromium: Browser,
    service: Service,
    finished: tuple[int, Any],
    scheme: Any,
    found: Callable[[Page], Iterator[str]],
) -> None:
    context = chromium.new_context(color_scheme=scheme, viewport={"width": 1280, "height": 900})
    visitor = Visitor(context.new_page(), service.url)

    for path in (f"/runs/{finished[0]}", f"/runs/{finished[0]}/embed"):
        visitor.open(path)
        assert list(found(visitor.page)) == [], path
    assert visitor.errors == []
    context.close()
