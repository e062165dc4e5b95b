"""Every number of the physics is shown with its source, from what the simulator uses."""

from html import unescape

import pytest

from seamark.sim import registry
from seamark.sim.physics import constants
from seamark.sim.vehicles import Quantity, load
from tests.server.pages.conftest import Site

QUANTITIES = [quantity for group in constants.GROUPS.values() for quantity in group]
QUANTITIES += [
    quantity for name in registry.VEHICLES for _place, quantity in load(name).quantities()
]


def missing(page: str, quantities: list[Quantity]) -> set[str]:
    text = unescape(page)
    return {q.meaning for q in quantities if q.meaning not in text or q.source not in text}


@pytest.mark.parametrize("path", ["/docs/physics", "/benchmarks/currents-v1"])
def test_every_number_is_shown_with_its_meaning_and_source(site: Site, path: str) -> None:
    assert missing(site.browser().get(path).text, QUANTITIES) == set()


def test_a_number_on_which_sources_differ_is_shown_with_their_spread(site: Site) -> None:
    page = unescape(site.browser().get("/docs/physics").text)

    assert "56.5 (18.18 to 141)" in page
    assert "5.5 (5.5 to 6.3567), 12.7 (7.1206 to 12.7), 14.6 (14.6 to 18.6863)" in page


@pytest.mark.parametrize("name", registry.BENCHMARKS)
def test_a_benchmark_shows_every_setting_with_its_source(site: Site, name: str) -> None:
    page = unescape(site.browser().get(f"/benchmarks/{name}").text)

    settings = registry.benchmark(name).schema()["properties"]
    sources = {entry["x-source"] for entry in settings.values() if entry.get("x-source")}
    assert [key for key in settings if f"<code>{key}</code>" not in page] == []
    assert sources
    assert {source for source in sources if source not in page} == set()


@pytest.mark.slow
def test_a_vehicle_can_be_downloaded_as_urdf(site: Site) -> None:
    answer = site.browser().get("/docs/physics/bluerov2-heavy.urdf")

    assert answer.mimetype == "application/xml"
    assert '<robot name="bluerov2-heavy">' in answer.text
