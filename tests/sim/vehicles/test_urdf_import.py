"""A URDF becomes the file of a vehicle: the rigid part is kept, the rest is listed or refused."""

import time

import numpy as np
import pytest

from seamark.sim.registry import VEHICLES
from seamark.sim.vehicles import Vehicle, load
from seamark.sim.vehicles.plausibility import findings
from seamark.sim.vehicles.reading import read_vehicle
from seamark.sim.vehicles.urdf import urdf_of
from seamark.sim.vehicles.urdf_import import import_urdf
from seamark.sim.vehicles.urdf_tree import LINKS_MAX, UrdfRefused
from seamark.sim.vehicles.xml_reading import BYTES_MAX, DEPTH_MAX, ELEMENTS_MAX

QUICK_S = 5.0  # of CPU
QUARTER = "1.5707963267948966"
INERTIA = '<inertia ixx="0.2" iyy="0.25" izz="0.3" ixy="0" ixz="0" iyz="0"/>'
BASE = f"""
  <link name="base_link">
    <inertial><origin xyz="0 0 -0.02"/><mass value="10"/>{INERTIA}</inertial>
    <collision><geometry><box size="0.5 0.4 0.25"/></geometry></collision>
    <visual><origin xyz="0 0.1 0.05" rpy="0 {QUARTER} 0"/>
      <geometry><cylinder radius="0.06" length="0.4"/></geometry>
      <material name="blue"><color rgba="0 0.2 0.8 1"/></material></visual>
  </link>
"""
BATTERY = f"""
  <link name="battery">
    <inertial><mass value="2"/>
      <inertia ixx="0.01" iyy="0.02" izz="0.03" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision name="tube"><geometry><cylinder radius="0.05" length="0.3"/></geometry></collision>
  </link>
  <joint name="strap" type="fixed"><parent link="base_link"/><child link="battery"/>
    <origin xyz="0.1 0.05 -0.15" rpy="0 {QUARTER} 0"/></joint>
"""
ARM = """
  <link name="upper"/><link name="lower"/>
  <joint name="shoulder" type="revolute"><parent link="base_link"/><child link="upper"/>
    <origin xyz="0.25 0.1 0"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/></joint>
"""


def robot(*parts: str) -> bytes:
    return f'<?xml version="1.0"?><robot name="My ROV">{"".join(parts)}</robot>'.encode()


def vehicle_of(content: bytes, *, z_down: bool = False) -> Vehicle:
    return read_vehicle(import_urdf(content, z_down=z_down).text.encode(), base=load)


def test_the_frame_of_ros_is_turned_to_z_down() -> None:
    vehicle = vehicle_of(robot(BASE))

    assert vehicle.name == "my-rov"
    assert vehicle.centre_of_gravity.value == (0.0, 0.0, 0.02)
    (solid,) = vehicle.solids
    assert (solid.shape, solid.size) == ("cylinder", (0.4, 0.12, 0.12))
    assert solid.centre == (0.0, -0.1, -0.05)
    assert solid.paint.colour == "#0033cc"


def test_links_that_are_fixed_are_one_body() -> None:
    vehicle = vehicle_of(robot(BASE, BATTERY))

    # In the frame of the URDF, by hand: the battery's z axis lies along x.
    base, battery = np.array([0.0, 0.0, -0.02]), np.array([0.1, 0.05, -0.15])
    centre = (10.0 * base + 2.0 * battery) / 12.0
    inertia = np.diag([0.2 + 0.03, 0.25 + 0.02, 0.3 + 0.01])
    for mass, place in ((10.0, base), (2.0, battery)):
        d = place - centre
        inertia += mass * (d @ d * np.eye(3) - np.outer(d, d))
    assert vehicle.mass.scalar == 12.0
    assert vehicle.centre_of_gravity.value == pytest.approx(centre * [1.0, -1.0, -1.0])
    assert vehicle.inertia.value == pytest.approx(np.diag(inertia))
    assert [piece.size.value for piece in vehicle.hull] == [(0.5, 0.4, 0.25), (0.3, 0.1, 0.1)]
    assert vehicle.hull[1].centre.value == pytest.approx((0.1, -0.05, 0.15))


def test_what_is_no_rigid_body_is_listed() -> None:
    mesh = BASE.replace('<box size="0.5 0.4 0.25"/>', '<mesh filename="hull.dae"/>')
    gazebo = "<gazebo/><transmission/>"

    left_out = import_urdf(robot(mesh, BATTERY, ARM, gazebo)).left_out

    told = " ".join(left_out)
    assert "<gazebo> elements" in told
    assert "<transmission> elements" in told
    assert "Joint 'shoulder' (revolute) at 0.25, -0.1, 0 m, with 2 links behind it." in left_out
    assert "Collision 'base_link 1': a mesh." in left_out
    assert any("Products of inertia up to" in one for one in left_out)
    assert len(left_out) == 5


@pytest.mark.parametrize("name", VEHICLES)
def test_the_urdf_that_we_write_comes_back(name: str) -> None:
    original = load(name)

    back = vehicle_of(urdf_of(original).encode(), z_down=True)

    assert back.name == f"my-{name}"
    assert back.mass.value == original.mass.value
    assert back.mass.source == f"the URDF of my-{name}"
    assert back.inertia.value == pytest.approx(original.inertia_about_gravity())
    assert back.centre_of_gravity.value == original.centre_of_gravity.value
    assert [piece.size.value for piece in back.hull] == [p.size.value for p in original.hull]


def test_an_imported_vehicle_can_run_at_once_and_says_what_is_a_placeholder() -> None:
    vehicle = vehicle_of(robot(BASE))

    tags = {place: quantity.tag for place, quantity in vehicle.quantities()}
    assert findings(vehicle) == []
    assert (tags["mass"], tags["buoyancy"], tags["drag_quadratic"]) == ("S", "E", "E")


BOMB = (
    '<!DOCTYPE bomb [<!ENTITY a "aaaaaaaaaa">'
    + "".join(f'<!ENTITY {chr(98 + n)} "{f"&{chr(97 + n)};" * 10}">' for n in range(9))
    + "]><robot>&j;</robot>"
)
REFUSED = {
    "a bomb": (BOMB.encode(), "declares a document type"),
    "an external entity": (
        b'<!DOCTYPE r [<!ENTITY x SYSTEM "file:///etc/passwd">]><robot>&x;</robot>',
        "declares a document type",
    ),
    "an external document type": (b'<!DOCTYPE r SYSTEM "http://x/y"><robot/>', "document type"),
    "an unknown entity": (b"<robot>&x;</robot>", "not valid XML"),
    "deep nesting": (b"<robot>" + b"<a>" * 100_000, f"more than {DEPTH_MAX} elements in each"),
    "a million elements": (b"<robot>" + b"<a/>" * 500_000, f"more than {ELEMENTS_MAX} elements"),
    "too large": (b" " * (BYTES_MAX + 1), "at most"),
    "a long attribute": (b'<robot name="' + b"x" * 100_000 + b'"/>', "exceeds 1000 characters"),
    "many attributes": (
        b"<robot " + b" ".join(b'a%d="x"' % n for n in range(100_000)) + b"/>",
        "one base link",
    ),
    "links": (robot("".join(f'<link name="a{n}"/>' for n in range(LINKS_MAX + 1))), "at most 500"),
    "not XML": (b"robot:", "not valid XML"),
    "nothing": (b"", "not valid XML"),
    "bytes": (b"\xff\xfe\x00", "not valid XML"),
    "an unknown encoding": (b'<?xml version="1.0" encoding="x-evil"?><robot/>', "not valid XML"),
    "another format": (b"<sdf/>", "no <robot> but <sdf>"),
    "a circle": (
        robot(BASE, '<link name="a"/><link name="b"/>',
              *(f'<joint name="{p}" type="fixed"><parent link="{p}"/><child link="{c}"/></joint>'
                for p, c in ("ab", "ba"))),
        "2 links are not joined to the base link",
    ),
    "two bases": (robot(BASE, '<link name="other"/>'), "one base link, which is no joint's child"),
    "two parents": (robot(BASE, BATTERY, BATTERY[BATTERY.index("  <joint"):]), "of two joints"),
    "no link": (robot(ARM), "names the link 'base_link', which is none"),
    "the same name": (robot(BASE, BASE), "Two links have the same name"),
    "no mass": (robot(BASE.replace('<mass value="10"/>', "")), "Neither the base link"),
    "zero mass": (robot(BASE.replace('value="10"', 'value="0"')), "Neither the base link"),
    "negative mass": (robot(BASE.replace('value="10"', 'value="-1"')), "is negative"),
    "no inertia": (robot(BASE.replace(INERTIA, "")), "No <inertia> is given"),
    "no hull": (robot(BASE.replace("<geometry>", "<other>").replace("</geometry>", "</other>")),
                "has no box, cylinder or sphere"),
    "a number": (robot(BASE.replace('value="10"', 'value="ten"')), "'ten' is not a number"),
    "infinity": (robot(BASE.replace('value="10"', 'value="inf"')), "not a finite number"),
    "not a number": (robot(BASE.replace('value="10"', 'value="nan"')), "not a finite number"),
    "two numbers": (robot(BASE.replace("0.5 0.4 0.25", "0.5 0.4")), "must be 3 numbers"),
    "no size": (robot(BASE.replace("0.5 0.4 0.25", "0.5 0 0.25")), "has no size"),
}  # fmt: skip


@pytest.mark.parametrize("attack", REFUSED)
def test_what_cannot_be_a_vehicle_is_refused_in_bounded_time(attack: str) -> None:
    content, said = REFUSED[attack]
    begin = time.process_time()

    with pytest.raises(UrdfRefused) as refused:
        import_urdf(content)

    assert time.process_time() - begin < QUICK_S
    assert said in str(refused.value)
    assert len(str(refused.value)) < 500


def test_names_cannot_break_out_of_the_file() -> None:
    evil = BASE.replace("<collision>", '<collision name="x&quot;&#10;[thrust]&#10;\\">')

    vehicle = vehicle_of(robot(evil).replace(b"My ROV", b"..&quot;/[a] = 1"))

    assert vehicle.name == "a-1"
    assert vehicle.hull[0].name.startswith("x_")


def test_a_chain_of_moving_joints_is_left_out_in_one_sentence() -> None:
    links = "".join(f'<link name="a{n}"/>' for n in range(400))
    joints = "".join(
        f'<joint type="continuous"><parent link="a{n}"/><child link="a{n + 1}"/></joint>'
        for n in range(399)
    )  # fmt: skip
    first = '<joint name="j" type="floating"><parent link="base_link"/><child link="a0"/></joint>'

    left_out = import_urdf(robot(BASE, links, joints, first)).left_out

    assert left_out == ["Joint 'j' (floating) at 0, 0, 0 m, with 400 links behind it."]
