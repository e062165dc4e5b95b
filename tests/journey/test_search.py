"""A search for the right box, seen on the page of its run and beside another one."""

import re

import pytest
from playwright.sync_api import Locator, expect

from tests.journey import accessibility
from tests.journey.visitor import PHONE_PX, RUN_MS, Visitor, width_on_a_phone

pytestmark = [pytest.mark.browser, pytest.mark.host, pytest.mark.slow]
MISSION = {
    "benchmark": "mission-v1",
    "controller": "chain",
    "seed": 5,
    "config": {"levels": [0.0], "loop1_values": [0.5, 2.0], "level_duration_s": 20.0},
}
LEVEL_S = 20.0


def test_the_map_of_a_search_plays_with_the_time_line(visitor: Visitor) -> None:
    visitor.sign_up("seeking")
    number = visitor.submit(MISSION)
    visitor.wait_elsewhere(number, timeout_ms=2 * RUN_MS)
    page = visitor.page

    visitor.open(f"/runs/{number}#t=4")
    search = page.locator("[data-level-map]")
    search.scroll_into_view_if_needed()

    expect(search.get_by_role("img", name=re.compile("Map of the search"))).to_be_visible()
    figures = search.locator("[data-map-figures]")
    expect(figures).to_contain_text(re.compile(r"Told position off by\s*[01]\.\d\d m"))
    expect(figures).to_contain_text("Box from the start")
    seen = search.locator('[data-map="seen"]')
    earlier = _pieces(seen)
    page.locator("[data-time]").fill("12")
    expect(seen).to_have_attribute("d", re.compile(rf"^(M[^M]*){{{earlier + 10},}}$"))
    start = search.locator('[data-map="mark"]').get_attribute("cx")
    page.locator("[data-time]").fill(str(LEVEL_S + 3))
    expect(search.locator('[data-map="mark"]')).not_to_have_attribute("cx", start or "")

    assert width_on_a_phone(page) <= PHONE_PX
    assert list(accessibility.defects(page)) == []
    assert (visitor.errors, visitor.violations()) == ([], [])


def test_the_maps_of_two_searches_are_beside_each_other(reader: Visitor) -> None:
    reader.sign_up("mapping")
    numbers = [reader.submit(MISSION | {"seed": seed}) for seed in (5, 6)]
    for number in numbers:
        reader.wait_elsewhere(number, timeout_ms=2 * RUN_MS)
    page = reader.page

    reader.open(f"/compare?runs={numbers[0]},{numbers[1]}&t=10")

    maps = page.locator("[data-level-map]")
    expect(maps).to_have_count(2)
    for one in maps.all():
        one.scroll_into_view_if_needed()
        expect(one.locator("[data-map-figures]")).to_contain_text("Way")
    expect(page.locator("[data-camera] img").first).to_be_visible()
    told = [one.locator('[data-map="told"]').get_attribute("transform") for one in maps.all()]
    assert told[0] != told[1]
    assert (reader.errors, reader.violations()) == ([], [])


def _pieces(path: Locator) -> int:
    """Return how many pieces a path of the map has: one for each row that it is drawn from."""
    return (path.get_attribute("d") or "").count("M")
