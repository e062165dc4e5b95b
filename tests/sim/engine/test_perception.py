"""The compiled code and the telemetry agree about which column is which."""

import pytest

from seamark.sim.engine.perception import thrust_column
from seamark.sim.recording.telemetry import names, width_for
from seamark.sim.vehicles.reading import THRUSTERS_MAX


@pytest.mark.parametrize("detections", [False, True])
@pytest.mark.parametrize(("arm", "work"), [(False, False), (True, False), (True, True)])
@pytest.mark.parametrize("thrusters", [8, 9, 16, THRUSTERS_MAX])
def test_every_thrust_has_the_column_of_its_name(
    thrusters: int, arm: bool, work: bool, detections: bool
) -> None:
    width = width_for(thrusters, arm=arm, work=work, detections=detections)

    columns = [thrust_column(thruster, width) for thruster in range(thrusters)]

    assert [names(width)[at] for at in columns] == [f"thrust_{n}" for n in range(thrusters)]
