"""A URDF becomes the file of an arm: joints, masses and shapes are kept, water is estimated."""

import math

import numpy as np
import pytest

from seamark.sim.vehicles.arm_check import figures
from seamark.sim.vehicles.kinematics import links_at, tip
from seamark.sim.vehicles.linkage import Linkage
from seamark.sim.vehicles.linkage_reading import read_linkage
from seamark.sim.vehicles.urdf_arm_import import import_arm
from seamark.sim.vehicles.urdf_tree import UrdfRefused

QUARTER = "1.5707963267948966"
INERTIA = '<inertia ixx="0.01" iyy="0.02" izz="0.02" ixy="0.001" ixz="0" iyz="0"/>'


def link(name: str, mass: float = 1.0) -> str:
    """A link with a rod of 0.3 m along its x axis."""
    return f"""
  <link name="{name}">
    <inertial><origin xyz="0.15 0 0.01"/><mass value="{mass}"/>{INERTIA}</inertial>
    <collision><origin xyz="0.15 0 0" rpy="0 {QUARTER} 0"/>
      <geometry><cylinder radius="0.02" length="0.3"/></geometry></collision>
    <visual><geometry><box size="0.3 0.04 0.04"/></geometry></visual>
  </link>"""


LIMIT = '<limit lower="-0.5" upper="1.0" effort="20" velocity="0.4"/>'
DYNAMICS = '<dynamics friction="0.3" damping="1"/>'
LEFT = f"""<joint name="lift" type="revolute"><parent link="base"/><child link="upper_arm"/>
    <origin xyz="0.1 0.2 0.3"/><axis xyz="0 2 0"/>{LIMIT}{DYNAMICS}</joint>"""
SLIDE = f"""<joint name="slide" type="prismatic"><parent link="upper_arm"/><child link="jaw"/>
    <origin xyz="0.3 0 0" rpy="0 0 {QUARTER}"/><axis xyz="1 0 0"/>{LIMIT}</joint>"""
OTHER = """<joint name="other" type="prismatic"><parent link="upper_arm"/><child link="twin"/>
    <origin xyz="0.3 0 0"/><axis xyz="1 0 0"/><limit lower="-0.5" upper="1.0"/>
    <mimic joint="slide" multiplier="-1"/></joint>"""


def robot(*parts: str) -> bytes:
    return f'<robot name="An arm"><link name="base"/>{"".join(parts)}</robot>'.encode()


WHOLE = robot(link("upper_arm"), link("jaw", 0.2), link("twin", 0.2), LEFT, SLIDE, OTHER)


def imported(content: bytes = WHOLE, *, z_down: bool = False) -> Linkage:
    return read_linkage(import_arm(content, z_down=z_down).text.encode())


def test_joints_keep_their_axes_limits_efforts_and_friction() -> None:
    arm = imported()
    lift, slide, other = (arm.link(name).joint for name in ("upper arm", "jaw", "twin"))

    assert arm.name == "an-arm"
    assert lift.kind == "revolute"
    assert lift.axis == (0.0, -1.0, 0.0)  # z is down here, so y is to starboard
    assert lift.place.point.value == (0.1, -0.2, -0.3)
    assert lift.range is not None
    assert lift.range.value == (-0.5, 1.0)
    assert lift.effort is not None
    assert (lift.effort.scalar, lift.effort.tag) == (20.0, "S")
    assert lift.friction is not None
    assert lift.friction.value == (0.3, 0.3)
    assert slide.kind == "prismatic"
    assert slide.place.turn.value == pytest.approx((0.0, 0.0, -0.5 * math.pi))
    assert other.follows == ("jaw", -1.0)
    assert arm.motors() == ("upper arm", "jaw")


def test_masses_are_kept_and_water_is_marked_as_a_placeholder() -> None:
    body = imported().link("upper arm").body
    assert body is not None

    assert body.mass.scalar == 1.0
    assert body.centre_of_mass.value == (0.15, 0.0, -0.01)
    assert body.inertia.value == (0.01, 0.02, 0.02, -0.001, 0.0, 0.0)
    assert body.mass.tag == "S"
    for quantity in (body.volume, body.added_mass, body.quadratic_drag):
        assert quantity.tag == "E"
        assert "placeholder" in quantity.source


def test_a_cylinder_becomes_a_capsule_along_it() -> None:
    arm = imported()

    (shape,) = arm.link("upper arm").shapes
    axes = links_at(arm, {})
    low = tip(arm, axes)

    assert shape.kind == "capsule"
    assert shape.size.value == pytest.approx((0.02, 0.13))
    turned = figures(arm)
    assert turned.reach_m > 0.3
    assert np.isfinite(low).all()


def test_the_arm_reaches_where_the_urdf_says() -> None:
    arm = imported()

    axes = links_at(arm, {"upper arm": 0.4, "jaw": 0.1})

    # In the URDF's axes, z up: the joint turns about y by 0.4 rad, the jaw slides along y.
    c, s = math.cos(0.4), math.sin(0.4)
    jaw = np.array([0.1 + 0.3 * c, 0.2 + 0.1, 0.3 - 0.3 * s])
    assert axes["jaw"].point == pytest.approx(jaw * [1.0, -1.0, -1.0])
    down = links_at(imported(z_down=True), {"upper arm": 0.4, "jaw": 0.1})
    assert down["jaw"].point == pytest.approx(jaw)


def test_what_touches_is_that_of_the_last_links_and_pairs_are_left_to_the_user() -> None:
    made = import_arm(WHOLE)

    assert imported().outer == ("jaw 1", "twin 1")
    assert any("write pairs of the gripper's to touches" in one for one in made.left_out)


def chained(i: int) -> str:
    parent = f"l{i - 1}" if i else "base"
    return (
        f'<joint name="j{i}" type="revolute"><parent link="{parent}"/><child link="l{i}"/></joint>'
    )


REFUSED = {
    "no joint": (robot(link("upper_arm"), LEFT.replace("revolute", "fixed")), "No joint turns"),
    "planar": (robot(link("upper_arm"), LEFT.replace("revolute", "planar")), "is 'planar'"),
    "no mass": (robot('<link name="upper_arm"/>', LEFT), "moves but has no <inertial>"),
    "no axis": (robot(link("upper_arm"), LEFT.replace("0 2 0", "0 0 0")), "An <axis> is zero"),
    "no such mimic": (
        robot(link("upper_arm"), link("jaw"), link("twin"), LEFT, SLIDE,
              OTHER.replace('"slide"', '"none"')),
        "mimics one that there is not",
    ),
    "many": (
        robot(*(link(f"l{i}") for i in range(40)), *(chained(i) for i in range(40))),
        "an arm has at most 32",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("content", "said"), REFUSED.values(), ids=REFUSED)
def test_what_is_no_arm_is_refused(content: bytes, said: str) -> None:
    with pytest.raises(UrdfRefused, match=said):
        import_arm(content)
