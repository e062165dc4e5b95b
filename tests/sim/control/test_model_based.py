"""The controllers that know their vehicle, from PI with feed-forward to MPC, and PID."""

from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from seamark.sim.control.observation import STARTS, Observation, empty
from seamark.sim.control.position import l1, lqr, mpc, pid
from seamark.sim.control.position.kalman_filter import BIAS, POSITION, VELOCITY, WATER, KalmanFilter
from seamark.sim.control.position.vehicle_model import DisturbanceObserver, VehicleModel
from seamark.sim.control.velocity_controller import VelocityController
from seamark.sim.engine.trial import run_trial
from seamark.sim.physics.thrusters import pack_curve, thrust_from_command
from seamark.sim.recording.telemetry import INDEX, Rows
from seamark.sim.registry import benchmark
from seamark.sim.vehicles import load

VEHICLES = ("girona500", "bluerov2-heavy")
MODEL_BASED = ("pi-ff", "smc", "lqr", "mpc", "l1")
CONFIG = benchmark("currents-v1").read({}).for_program()


def driven(name: str, **settings: Any) -> Rows:
    entry = benchmark("currents-v1")
    scenario = {"tracker": "truth", "levels": [0.3], "level_duration_s": 30.0, "settle_s": 10.0}
    config = entry.read(scenario | settings)
    rows: list[Rows] = []
    program = entry.load().built_in(name, config)
    run_trial(
        "currents-v1",
        config,
        program,
        seed=5,
        trial=0,
        on_rows=lambda some: rows.append(some.copy()),
    )
    return np.concatenate(rows)


def rmse_m(rows: Rows) -> float:
    late = rows[len(rows) // 3 :, INDEX["distance"]]
    return float(np.sqrt(np.mean(late * late)))


def observed(**fields: Any) -> Observation:
    values = empty(5)
    values[STARTS["dt"]] = 0.05
    values[STARTS["velocity_valid"]] = values[STARTS["target_visible"]] = 1.0
    for name, value in fields.items():
        values[STARTS[name] : STARTS[name] + np.size(value)] = value
    return Observation(values)


@pytest.mark.parametrize("vehicle", VEHICLES)
@pytest.mark.parametrize("name", [*MODEL_BASED, "pid"])
def test_it_holds_station_better_than_a_pi_with_the_published_gains(
    name: str, vehicle: str
) -> None:
    assert rmse_m(driven(name, vehicle=vehicle)) < 0.6 * rmse_m(driven("pi", vehicle=vehicle))


@pytest.mark.parametrize("name", MODEL_BASED)
def test_a_bias_of_the_dvl_costs_it_little(name: str) -> None:
    assert rmse_m(driven(name, dvl_bias_m_s=0.02)) < rmse_m(driven(name)) + 0.01


@pytest.mark.parametrize("name", MODEL_BASED)
def test_it_starts_a_level_as_if_there_had_been_none_before(name: str) -> None:
    both = driven(name, levels=[0.2, 0.3], level_duration_s=10.0, settle_s=5.0, current_gust=0.0)
    first, second = both[:200], both[200:]
    alone = driven(name, levels=[0.2], level_duration_s=10.0, settle_s=5.0, current_gust=0.0)

    reference = slice(INDEX["ref_u"], INDEX["ref_r"] + 1)
    assert np.array_equal(first[:, reference], alone[:, reference])
    assert np.abs(second[0, reference]).max() < 0.02


def test_the_reference_of_a_force_makes_the_velocity_controller_give_that_force() -> None:
    vehicle = load("girona500")
    config = benchmark("currents-v1").read({"depth_hold": False, "heading_hold": False})
    controller, model = VelocityController(vehicle, config), VehicleModel(config.for_program())
    controller.measured["fresh"] = 1.0
    controller.measured["velocity"] = (0.05, -0.02, 0.0)
    model.update(observed(velocity=(0.05, -0.02, 0.0)))

    references = [model.reference(axis, force) for axis, force in enumerate((60.0, -40.0))]
    commands = controller.step((references[0], references[1], 0.0, 0.0), 0.05).tolist()

    curve = pack_curve(vehicle.curve)
    thrust = np.array([thrust_from_command(command, curve) for command in commands])
    assert vehicle.allocation()[:2] @ thrust == pytest.approx([60.0, -40.0], rel=0.02)


def test_the_disturbance_observer_finds_the_force_that_thrust_balances() -> None:
    model = VehicleModel(CONFIG)
    observer = DisturbanceObserver(model, 2.0)
    pushing = observed(thrust=(20.0, 20.0, 0.0, 0.0, 15.0), velocity=(0.02, 0.02, 0.0))
    for _ in range(200):
        model.update(pushing)
        observer.update(pushing)

    assert observer.force == pytest.approx([-value for value in model.force], rel=0.01)
    assert min(map(abs, model.force)) > 10.0


def test_the_kalman_filter_separates_the_bias_of_the_dvl_from_the_velocity() -> None:
    found = KalmanFilter(0.05)
    for step in range(2400):
        found.predict([0.0, 0.0], 0.0, 0.05)
        found.correct(
            (POSITION,),
            [-state[POSITION] for state in found.states],
            0.003,
        )
        if step % 4 == 0:
            innovations = [0.03 - state[VELOCITY] - state[BIAS] for state in found.states]
            found.correct((VELOCITY, BIAS), innovations, 0.003)

    assert [state[BIAS] for state in found.states] == pytest.approx([0.03, 0.03], abs=0.002)
    assert [state[VELOCITY] for state in found.states] == pytest.approx([0, 0], abs=0.002)


def test_the_kalman_filter_turns_its_vectors_with_the_vehicle() -> None:
    found = KalmanFilter(0.05)
    found.states[0][WATER] = 1.0
    for _ in range(1571):
        found.predict([-state[WATER] for state in found.states], 0.001, 0.001)

    assert [state[WATER] for state in found.states] == pytest.approx([0.0, -1.0], abs=0.01)


def test_an_old_image_is_compared_with_the_old_position() -> None:
    controller = lqr.Controller(CONFIG | {"lqr_delay_s": 0.1})
    controller.reset({})
    controller.estimator.filter.states[0][VELOCITY] = 1.0
    controller.step(observed(target_visible=0.0, velocity_valid=0.0))
    controller.step(observed(target_visible=0.0, velocity_valid=0.0))

    controller.step(observed(error=(-0.05, 0.0, 0.0), velocity_valid=0.0))

    assert controller.estimator.past[0][0] == pytest.approx(0.05, rel=0.05)
    assert controller.estimator.filter.states[0][POSITION] == pytest.approx(0.15, rel=0.05)


def test_l1_control_finds_the_water_that_thrust_balances_and_the_bias_of_the_dvl() -> None:
    controller = l1.Controller(CONFIG)
    for step in range(400):
        wobble = 1e-6 * (step // 4)  # a new reading every fourth step
        sensed = observed(thrust=(20.0, 20.0, 0.0, 0.0, 15.0), velocity=(0.02 + wobble, -0.01, 0.0))
        controller.step(sensed)

    pushes = [controller.model.force[axis] / controller.model.mass[axis] for axis in (0, 1)]
    assert controller.slow_water == pytest.approx([-push for push in pushes], rel=0.1)
    assert controller.slow_drift == pytest.approx([-0.02, 0.01], abs=0.002)


def test_mpc_leaves_to_the_moment_what_its_thrust_takes() -> None:
    thrusters = mpc.Thrusters("bluerov2-heavy")

    low, high = thrusters.room([0.0] * 8)
    turning_low, turning_high = thrusters.room([-20.0, 20.0, -20.0, 20.0, *([0.0] * 4)])

    assert high == pytest.approx([mpc.MARGIN] * 4)
    assert np.count_nonzero(turning_high < high - 0.1) == 2
    assert np.count_nonzero(turning_low > low + 0.1) == 2


def test_the_integral_of_the_pid_follows_the_limit() -> None:
    controller = pid.Controller(CONFIG)
    answers = [controller.step(observed(error=(9.0, 0.0, 0.0)))[0] for _ in range(400)]

    assert answers == [1.0] * 400
    assert controller.step(observed(error=(-0.1, 0.0, 0.0)))[0] < 0.0


def test_the_pid_turns_the_vehicle_back_to_the_heading_of_the_station() -> None:
    controller = pid.Controller(CONFIG | {"heading_gain_1_s": 0.5})

    command = controller.step(observed(attitude=(0.0, 0.0, 0.2)))

    assert command[3] == pytest.approx(-0.1)


@pytest.mark.parametrize("name", MODEL_BASED)
def test_its_reference_does_not_chatter(name: str) -> None:
    surge = driven(name)[200:, INDEX["ref_u"]].tolist()

    assert sum(abs(b - a) for a, b in pairwise(surge)) < 0.02 * len(surge)
