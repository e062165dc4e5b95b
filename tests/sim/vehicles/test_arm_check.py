"""What is derived from an arm's numbers is right, and what is wrong with it is said."""

import math
from xml.etree import ElementTree

import numpy as np
import pytest

from seamark.sim.registry import ARMS
from seamark.sim.vehicles.arm_check import ArmFigures, JointFigures, figures, findings
from seamark.sim.vehicles.arm_drawing import arm_drawing
from seamark.sim.vehicles.kinematics import home, links_at
from seamark.sim.vehicles.linkage_reading import load_linkage, read_linkage
from seamark.sim.vehicles.model import STANDARD_GRAVITY

HOOK, ALPHA = ARMS["hook"].read_text("utf-8"), ARMS["alpha-like"].read_text("utf-8")


def joint(found: ArmFigures, name: str) -> JointFigures:
    return next(one for one in found.joints if one.name == name)


def told(text: str) -> list[str]:
    arm = read_linkage(text.encode())
    return [f"{one.grade}: {one.text}" for one in findings(arm, figures(arm))]


def changed(text: str, before: str, after: str) -> str:
    assert before in text
    return text.replace(before, after)


def test_the_hook_holds_what_two_cylinders_weigh() -> None:
    upper = STANDARD_GRAVITY * (1.0 - 1000.0 * math.pi * 0.025**2 * 0.3)
    fore = STANDARD_GRAVITY * (0.8 - 1000.0 * math.pi * 0.02**2 * 0.3)
    needed = 0.15 * upper + 0.45 * fore

    found = figures(load_linkage("hook"))

    assert found.reach_m == pytest.approx(0.69)
    assert found.weight_in_water_n == pytest.approx(upper + fore)
    assert joint(found, "upper arm").own_weight == pytest.approx(needed)
    assert joint(found, "upper arm").payload_n == pytest.approx((40.0 - needed) / 0.69)
    assert found.payload_n == joint(found, "upper arm").payload_n


@pytest.mark.slow
def test_figures_of_our_arms_are_those_that_are_published() -> None:
    larger, smaller = figures(load_linkage("arm-5e-like")), figures(load_linkage("alpha-like"))

    assert larger.payload_n == pytest.approx(25.0 * STANDARD_GRAVITY, rel=0.1)
    assert larger.reach_m == pytest.approx(1.0, rel=0.05)
    assert larger.weight_in_water_n == pytest.approx(18.5 * STANDARD_GRAVITY, rel=0.01)
    assert smaller.reach_m == pytest.approx(0.41, abs=0.002)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["alpha-like", "arm-5e-like"])
def test_nothing_is_wrong_with_our_arms(name: str) -> None:
    arm = load_linkage(name)

    assert findings(arm, figures(arm)) == []


def test_a_motor_that_cannot_hold_the_arm_is_told() -> None:
    weak = changed(HOOK, "value = 40.0", "value = 2.0")

    (sentence,) = [one for one in told(weak) if "hold the arm" in one]

    assert sentence == (
        "warning: upper arm: to hold the arm stretched out in water takes 2.47 N m; its motor "
        "gives 2."
    )


def test_jaws_without_the_inertia_of_their_motor_are_told() -> None:
    light = changed(ALPHA, "rotor = { value = 0.005", "rotor = { value = 0.0")

    assert any("jaw port: its motor would bring it to" in one for one in told(light))


def test_a_gear_that_its_motor_cannot_turn_is_an_error() -> None:
    stiff = changed(HOOK, "friction = { value = [0.5, 0.4]", "friction = { value = [50.0, 0.4]")

    assert "error: upper arm: its friction to break away, 50 N m" in told(stiff)[0]


def test_an_arm_without_outer_shapes_is_told_that_it_touches_nothing() -> None:
    inner = changed(HOOK, 'outer = ["hook back", "hook tip"]', "outer = []")

    assert any("the arm can touch nothing" in one for one in told(inner))


def test_an_arm_without_a_force_sensor_is_told_so() -> None:
    blind = HOOK[: HOOK.index("[force_sensor]")]

    assert "warning: There is no force_sensor: programs will not have its readings." in told(blind)


def test_a_hook_is_told_that_it_does_not_grip() -> None:
    assert any("it has no gripper that closes" in one for one in told(HOOK))


def test_a_link_that_weighs_nothing_against_its_drag_is_told() -> None:
    light = changed(HOOK, "mass = { value = 0.8", "mass = { value = 0.0001")
    dragging = changed(light, "[links.body.cylinder]", (
        'quadratic_drag = { value = [1e4, 1e4, 1e4], unit = "N s²/m²", tag = "E", reason = "?" }\n'
        "[links.body.cylinder]"
    ))  # fmt: skip

    assert any("more than the integrator follows" in one for one in told(dragging))


@pytest.mark.parametrize("name", ARMS)
def test_an_arm_is_drawn_from_three_sides(name: str) -> None:
    arm = load_linkage(name)

    root = ElementTree.fromstring(arm_drawing(arm))  # noqa: S314  # our own text

    solids = sum(len(link.solids) for link in arm.links)
    drawn = [one for one in root.iter() if one.get("class") == "solid"]
    assert len(drawn) == 3 * solids


def test_a_link_that_follows_moves_with_the_other() -> None:
    arm = load_linkage("alpha-like")
    start = home(arm)

    closed, opened = (links_at(arm, start | {"jaw port": angle}) for angle in (0.0, 0.5))

    for jaw in ("jaw port", "jaw starboard"):
        turned = closed[jaw].turn.T @ opened[jaw].turn
        assert np.trace(turned) == pytest.approx(1.0 + 2.0 * math.cos(0.5))
