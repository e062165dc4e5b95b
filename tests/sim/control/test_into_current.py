"""The parts of the controller that turns the bow: its estimate of the water and its moments."""

import math

import pytest

from seamark.sim.camera.optics import MOUNT_M
from seamark.sim.control.observation import STARTS, Observation, empty
from seamark.sim.control.position.into_current import CAMERA_M, TOOL_AHEAD_M, Controller
from seamark.sim.control.position.kalman_filter import VELOCITY
from seamark.sim.control.position.vehicle_model import VehicleModel
from seamark.sim.control.position.water_filter import WaterFilter
from seamark.sim.control.position.yaw_moment import YawMoment
from seamark.sim.metrics import tool_point
from seamark.sim.registry import benchmark
from seamark.sim.vehicles import load

CONFIG = benchmark("currents-v3").read({"vehicle": "girona500"}).for_program()
DT, SPEED_M_S, TURN_RAD_S = 0.05, 0.4, 0.1


def standing(model: VehicleModel, yaw: float, step: int) -> Observation:
    """A vehicle that stands and turns in water from the north, pushed by what that takes."""
    surge, sway = -SPEED_M_S * math.cos(yaw), SPEED_M_S * math.sin(yaw)
    turning = (model.added[1] - model.added[0]) * TURN_RAD_S
    ahead = -model.drag(0, surge) + turning * sway
    aside = -model.drag(1, sway) + turning * surge
    values = empty(5)
    values[STARTS["dt"]] = DT
    values[STARTS["velocity"]] = 1e-9 * step  # a new reading each time
    values[STARTS["velocity_valid"]] = 1.0
    values[STARTS["attitude"] + 2] = yaw
    values[STARTS["rates"] + 2] = TURN_RAD_S
    values[STARTS["thrust"] : STARTS["thrust"] + 5] = (ahead / 2, ahead / 2, 0.0, 0.0, aside)
    return Observation(values)


def test_camera_and_tool_are_where_the_controller_says() -> None:
    assert CAMERA_M == MOUNT_M
    assert TOOL_AHEAD_M == tool_point.TOOL_AHEAD_M


def test_the_estimated_current_stays_while_the_hull_turns_in_it() -> None:
    model = VehicleModel(CONFIG)
    water = WaterFilter(model, (0.0, 0.0, 0.0), water_m_s2=0.05, delay_steps=0)
    yaw, found = 0.0, []
    for step in range(500):
        seen = standing(model, yaw, step)
        model.update(seen)
        water.update(seen)
        surge, sway = (
            past + state[VELOCITY]
            for past, state in zip(water.through(), water.states, strict=True)
        )
        north = math.cos(yaw) * surge - math.sin(yaw) * sway
        east = math.sin(yaw) * surge + math.cos(yaw) * sway
        found.append((north, east))
        yaw += TURN_RAD_S * DT

    assert yaw > 2.0
    for north, east in found[200:]:
        assert north == pytest.approx(-SPEED_M_S, abs=0.06)
        assert east == pytest.approx(0.0, abs=0.06)


def test_a_moment_from_the_water_is_found_and_taken_away() -> None:
    vehicle, disturbance = load("girona500"), 12.0
    model = VehicleModel(CONFIG)
    moments = YawMoment(vehicle, model)
    inertia = (vehicle.mass_rigid() + vehicle.mass_added()).item(5, 5)
    yaw, turning, given = 0.0, 0.0, 0.0
    for _ in range(400):
        moments.rate((0.0, 0.0, 0.0), yaw, turning, DT)
        given += (moments.moment - given) * DT / (model.lag_s + DT)
        turning += (given + disturbance) / inertia * DT
        yaw += turning * DT

    assert moments.moment == pytest.approx(-disturbance, abs=0.5)
    assert yaw == pytest.approx(0.0, abs=0.01)


def test_forces_leave_each_thruster_room_for_the_moment() -> None:
    controller = Controller(CONFIG)
    controller.yaw.moment = 20.0

    forces, share = controller._within([1000.0, -400.0])

    assert 0.0 < share < 1.0
    assert forces == pytest.approx([1000.0 * share, -400.0 * share])
    assert controller._within([1.0, 1.0]) == ([1.0, 1.0], 1.0)
    for by_surge, by_sway, by_yaw in controller._shares:
        thrust = by_surge * forces[0] + by_sway * forces[1] + by_yaw * 20.0
        assert abs(thrust) < 1.2 * 104.7 + 1e-9
