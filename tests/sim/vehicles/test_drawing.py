"""The drawing of a vehicle: well formed, complete, and safe with any names."""

from dataclasses import replace
from xml.etree import ElementTree

import pytest

from seamark.sim.registry import VEHICLES
from seamark.sim.vehicles import load
from seamark.sim.vehicles.drawing import drawing

SVG = "{http://www.w3.org/2000/svg}"


def of_class(root: ElementTree.Element, name: str) -> list[ElementTree.Element]:
    return [element for element in root.iter() if element.get("class") == name]


@pytest.mark.parametrize("name", VEHICLES)
def test_each_view_has_every_solid_hull_box_and_thruster(name: str) -> None:
    vehicle = load(name)

    root = ElementTree.fromstring(drawing(vehicle))  # noqa: S314  # our own text

    titles = [element.text for element in root.iter(f"{SVG}title")]
    assert len(of_class(root, "solid")) == 3 * len(vehicle.drawn())
    assert len(of_class(root, "hull")) == 3 * len(vehicle.hull)
    for number, thruster in enumerate(vehicle.thrusters):
        assert titles.count(f"{number}: {thruster.name}") == 3


@pytest.mark.parametrize("name", VEHICLES)
def test_everything_is_on_the_page(name: str) -> None:
    root = ElementTree.fromstring(drawing(load(name)))  # noqa: S314  # our own text
    width, height = float(root.get("width", "")), float(root.get("height", ""))

    for box in (*of_class(root, "hull"), *(e for e in of_class(root, "solid") if e.get("x"))):
        x, y, w, h = (float(box.get(key, "")) for key in ("x", "y", "width", "height"))
        assert x >= 0.0
        assert y >= 0.0
        assert x + w <= width
        assert y + h <= height


def test_a_forward_thruster_is_an_arrow_to_the_right_seen_from_starboard() -> None:
    root = ElementTree.fromstring(drawing(load("girona500")))  # noqa: S314  # our own text

    arrow = next(element for element in of_class(root, "thruster") if element.tag == f"{SVG}line")

    x1, y1, x2, y2 = (float(arrow.get(key, "")) for key in ("x1", "y1", "x2", "y2"))
    assert x2 > x1
    assert y2 == y1


def test_names_cannot_add_elements_to_the_drawing() -> None:
    evil = "<script>alert(1)</script>&"
    vehicle = load("girona500")
    first = replace(vehicle.thrusters[0], name=evil)
    named = replace(vehicle, title=evil, thrusters=(first, *vehicle.thrusters[1:]))

    root = ElementTree.fromstring(drawing(named))  # noqa: S314  # our own text

    assert list(root.iter(f"{SVG}script")) == []
    assert f"0: {evil}" in [element.text for element in root.iter(f"{SVG}title")]
