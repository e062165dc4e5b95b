"""The kinematics that controllers use agree with the mechanism that is simulated."""

import numpy as np
import pytest

from seamark.sim.control.manipulation.arm_reading import data_of, mount_of
from seamark.sim.control.manipulation.kinematics import ArmKinematics, applied, rotation
from seamark.sim.multibody.assembly import Mounting, assemble
from seamark.sim.multibody.posture import Posture
from seamark.sim.registry import VEHICLES
from seamark.sim.vehicles import load
from seamark.sim.vehicles.linkage_reading import load_linkage

CARRIED = [(name, arm) for name in VEHICLES for arm in load(name).mounts]
STEP_RAD = 1e-6


def poses(kinematics: ArmKinematics) -> list[list[float]]:
    """Return joints at home, and two poses within their ranges."""
    ranges = kinematics.ranges
    return [
        kinematics.home,
        *([low + share * (high - low) for low, high in ranges] for share in (0.3, 0.6)),
    ]


@pytest.mark.parametrize(("name", "arm"), CARRIED)
def test_the_tool_is_where_the_simulated_mechanism_has_it(name: str, arm: str) -> None:
    vehicle, linkage = load(name), load_linkage(arm)
    kinematics = ArmKinematics(data_of(linkage), mount_of(vehicle, arm))
    mounting = Mounting(linkage=linkage, place=vehicle.mounts[arm], on_vehicle=True)
    assembly = assemble(vehicle, [mounting], bottom=False)
    posture = Posture(assembly)
    assert assembly.tool is not None
    link = assembly.mechanism.number(assembly.tool.link)

    for joints in poses(kinematics):
        motion = np.concatenate([np.zeros(12), joints, np.zeros(len(joints))])
        turns, points, _ = posture.place(motion)
        tool = kinematics.tool(joints)

        assert tool.point == pytest.approx(turns[link] @ assembly.tool.point + points[link])
        assert np.array(tool.turn) == pytest.approx(turns[link] @ assembly.tool.turn)


@pytest.mark.parametrize(("name", "arm"), CARRIED)
def test_the_jacobian_is_the_derivative_of_the_tools_place(name: str, arm: str) -> None:
    kinematics = ArmKinematics(data_of(load_linkage(arm)), mount_of(load(name), arm))

    for joints in poses(kinematics):
        tool, columns = kinematics.jacobian(joints)
        assert set(columns) == set(kinematics.reaching)
        for motor, (velocity, axis) in columns.items():
            moved = [q + STEP_RAD * (number == motor) for number, q in enumerate(joints)]
            after = kinematics.tool(moved)
            change = (np.array(after.point) - tool.point) / STEP_RAD
            turned = (np.array(after.turn) - tool.turn) @ np.array(tool.turn).T / STEP_RAD

            assert velocity == pytest.approx(change, abs=1e-5)
            assert axis == pytest.approx([turned[2, 1], turned[0, 2], turned[1, 0]], abs=1e-5)


def test_an_arm_without_a_tool_is_refused() -> None:
    peg = load_linkage("peg")

    with pytest.raises(ValueError, match="peg has no tool"):
        data_of(peg)


def test_attitudes_turn_first_by_roll_then_by_pitch_then_by_yaw() -> None:
    ahead = applied(rotation(0.3, 0.0, 0.0), (1.0, 0.0, 0.0))
    nose_up = applied(rotation(0.0, 0.5, 0.0), (1.0, 0.0, 0.0))
    to_the_east = applied(rotation(0.0, 0.0, 0.5 * np.pi), (1.0, 0.0, 0.0))

    assert ahead == pytest.approx((1.0, 0.0, 0.0))
    assert nose_up == pytest.approx((np.cos(0.5), 0.0, -np.sin(0.5)))
    assert to_the_east == pytest.approx((0.0, 1.0, 0.0))
