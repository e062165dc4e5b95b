"""A route that is followed, seen on the page of its run and beside another one."""

import re

import pytest
from playwright.sync_api import Locator, expect

from tests.journey import accessibility
from tests.journey.visitor import PHONE_PX, RUN_MS, Visitor, width_on_a_phone

pytestmark = [pytest.mark.browser, pytest.mark.host, pytest.mark.slow]
TRACK = {
    "benchmark": "track-v1",
    "controller": "ilos",
    "seed": 3,
    "config": {"levels": [0.0, 0.2], "level_duration_s": 30.0, "shuffle_levels": False},
}
LEVEL_S = 30.0


def test_the_map_of_a_route_plays_with_the_time_line(visitor: Visitor) -> None:
    visitor.sign_up("routing")
    number = visitor.submit(TRACK)
    visitor.wait_elsewhere(number, timeout_ms=2 * RUN_MS)
    page = visitor.page

    visitor.open(f"/runs/{number}#t=5")
    route = page.locator("[data-level-map]")
    route.scroll_into_view_if_needed()

    expect(route.get_by_role("img", name=re.compile("Map of the route"))).to_be_visible()
    figures = route.locator("[data-map-figures]")
    expect(figures).to_contain_text(re.compile(r"Told start off by\s*[01]\.\d\d m"))
    expect(figures).to_contain_text(re.compile(r"Along the route\s*\d+\.\d m of 30\.0 m"))
    done, rest, way = (route.locator(f'[data-map="{name}"]') for name in ("done", "rest", "way"))
    corners, followed, went = _corners(rest), _corners(done), _corners(way)
    page.locator("[data-time]").fill("25")
    expect(rest).not_to_have_attribute("d", re.compile(rf"^([^L]*L){{{corners - 1},}}[^L]*$"))
    assert _corners(done) > followed
    assert _corners(way) >= went + 60  # four rows a second are drawn
    expect(route.locator('[data-map="fix"]')).to_have_attribute("d", re.compile("a"))

    first = done.get_attribute("d")
    page.locator("[data-time]").fill(str(LEVEL_S))
    expect(figures).to_contain_text("none yet")  # a level begins without a fix
    expect(done).not_to_have_attribute("d", first or "")

    assert width_on_a_phone(page) <= PHONE_PX
    assert list(accessibility.defects(page)) == []
    assert (visitor.errors, visitor.violations()) == ([], [])


def test_the_page_of_a_route_says_nothing_of_a_tracker(visitor: Visitor) -> None:
    visitor.sign_up("untracked")
    number = visitor.submit(TRACK)
    visitor.wait_elsewhere(number, timeout_ms=2 * RUN_MS)
    page = visitor.page

    visitor.open(f"/runs/{number}#t=5")

    expect(page.locator("[data-camera] img")).to_be_visible()
    expect(page.locator("[data-numbers]")).to_contain_text(re.compile(r"Off the route\s*\d"))
    for text in ("Tracker", "Ground truth", "Zoom to target", "target lost", "Target first lost"):
        expect(page.locator("[data-player]").get_by_text(text, exact=True)).to_have_count(0)
    expect(page.get_by_role("radio", name="Route")).to_be_checked()
    expect(page.get_by_role("radio", name="Target")).to_have_count(0)
    page.get_by_label("Jump to").select_option(label="Largest error")
    expect(page.locator("[data-clock]")).not_to_contain_text("5.00 s")
    assert (visitor.errors, visitor.violations()) == ([], [])


def test_the_maps_of_two_routes_are_beside_each_other(reader: Visitor) -> None:
    reader.sign_up("two-routes")
    numbers = [reader.submit(TRACK | {"seed": seed}) for seed in (3, 4)]
    for number in numbers:
        reader.wait_elsewhere(number, timeout_ms=2 * RUN_MS)

    reader.open(f"/compare?runs={numbers[0]},{numbers[1]}&t=10")

    maps = reader.page.locator("[data-level-map]")
    expect(maps).to_have_count(2)
    for one in maps.all():
        one.scroll_into_view_if_needed()
        expect(one.locator("[data-map-figures]")).to_contain_text("Off the route")
    rests = [one.locator('[data-map="rest"]').get_attribute("d") for one in maps.all()]
    assert rests[0] != rests[1]
    assert (reader.errors, reader.violations()) == ([], [])


def _corners(path: Locator) -> int:
    """Return how many pieces a line of the map has."""
    return (path.get_attribute("d") or "").count("L")
