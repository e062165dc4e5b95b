"""Thruster allocation, and velocities that are reached and held."""

import numpy as np
import pytest

from seamark.sim.control.allocation import HEAVE, PITCH, ROLL, SURGE, SWAY, YAW, allocator
from seamark.sim.control.velocity_controller import VelocityController
from seamark.sim.physics.current import Current, Pattern
from seamark.sim.physics.plant import Plant
from seamark.sim.registry import VEHICLES, benchmark
from seamark.sim.vehicles import load

START = np.array([0.0, 0.0, 1.5, 0.0, 0.0, 0.3])
Reference = tuple[float, float, float, float]


def settled(reference: Reference, *, current: float = 0.0, **settings: object) -> Plant:
    """Return the plant after a minute, with a perfect DVL."""
    config = benchmark("currents-v1").read(settings)
    vehicle = load(config.model_dump()["vehicle"])
    plant = Plant(vehicle, Current(current, pattern=Pattern(azimuth_rad=0.3, speed_swing=0.0)))
    plant.reset(START)
    controller = VelocityController(vehicle, config)
    for step in range(1200):
        pose, (u, v, w, p, q, r) = plant.pose(), plant.velocity().tolist()
        tilt = (float(pose[3]), float(pose[4]))
        controller.measured[0] = (
            *((u, v, w), float(pose[2]), float(pose[5]), r),
            *(float(step % 4 == 0), tilt, (p, q)),
        )
        if step == 0:
            controller.reset()
        plant.advance(step * 5, controller.step(reference, 0.05), 5)
    return plant


@pytest.mark.parametrize("name", VEHICLES)
def test_allocated_thrusts_give_the_desired_wrench(name: str) -> None:
    vehicle = load(name)

    made = vehicle.allocation() @ allocator(vehicle)

    wanted = np.eye(6)
    wanted[ROLL, ROLL] = 0.0  # these vehicles cannot roll themselves
    axes = [SURGE, SWAY, HEAVE, PITCH, YAW]
    assert made[:, axes] == pytest.approx(wanted[:, axes], abs=1e-12)


@pytest.mark.parametrize("name", VEHICLES)
def test_the_allocation_is_the_pseudo_inverse(name: str) -> None:
    vehicle = load(name)

    assert allocator(vehicle) == pytest.approx(np.linalg.pinv(vehicle.allocation()), abs=1e-12)


@pytest.mark.parametrize("reference", [(0.2, 0.0, 0.0, 0.0), (0.0, 0.15, 0.0, 0.0)])
@pytest.mark.parametrize("current", [0.0, 0.2])
def test_a_velocity_reference_is_reached_in_the_current(
    reference: Reference, current: float
) -> None:
    velocity = settled(reference, current=current, velocity_observer_1_s=1.5).velocity()

    assert velocity[:3] == pytest.approx(reference[:3], abs=0.02)


def test_depth_and_heading_are_held_in_the_current() -> None:
    pose = settled((0.0, 0.0, 0.0, 0.0), current=0.3).pose()

    assert pose[2] == pytest.approx(START[2], abs=0.02)
    assert pose[5] == pytest.approx(START[5], abs=0.05)


@pytest.mark.parametrize(("tilt_hold", "upright"), [(True, True), (False, False)])
def test_a_bluerov_stays_upright_in_a_strong_current_if_its_tilt_is_held(
    tilt_hold: bool, upright: bool
) -> None:
    plant = settled(
        (0.0, 0.0, 0.0, 0.0),
        current=0.5,
        vehicle="bluerov2-heavy",
        velocity_observer_1_s=1.5,
        tilt_hold=tilt_hold,
    )

    assert (np.abs(plant.pose()[3:5]).max() < 0.1) == upright


def test_a_yaw_rate_turns_the_held_heading() -> None:
    pose = settled((0.0, 0.0, 0.0, 0.02)).pose()

    assert pose[5] == pytest.approx(START[5] + 60 * 0.02, abs=0.03)


def test_a_heave_reference_moves_the_held_depth() -> None:
    pose = settled((0.0, 0.0, 0.01, 0.0)).pose()

    assert pose[2] == pytest.approx(START[2] + 60 * 0.01, abs=0.03)


def test_the_effort_of_the_papers_law_is_proportional_to_the_error() -> None:
    config = benchmark("currents-v1").read({"vehicle": "girona500-uwsim"})
    controller = VelocityController(load("girona500-uwsim"), config)
    controller.measured["velocity"], controller.measured["depth"] = (0.01, 0.02, 0.03), 1.0

    command = controller.step((0.05, 0.0, 0.0, 0.0), 0.05)

    assert command.tolist() == pytest.approx([0.2, 0.2, -0.15, -0.15, -0.12])


def test_commands_and_references_are_limited() -> None:
    config = benchmark("currents-v1").read({"reference_limit_m_s": 0.1})
    vehicle = load("girona500")

    commands = []
    for reference in ((9.0, -9.0, 0.0, 0.0), (0.1, -0.1, 0.0, 0.0)):
        controller = VelocityController(vehicle, config)
        controller.measured["depth"] = 1.0
        commands.append(controller.step(reference, 0.05))

    wild, cut = commands
    assert np.array_equal(wild, cut)
    assert np.abs(wild).max() <= 1.0
