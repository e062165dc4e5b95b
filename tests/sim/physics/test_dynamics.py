"""The plant against what can be worked out by hand."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.random_streams import streams
from seamark.sim.physics.current import Current, Pattern
from seamark.sim.physics.plant import Plant
from seamark.sim.registry import VEHICLES
from seamark.sim.vehicles import Quantity, Vehicle, load
from tests.services.prepared import printed

STILL = Current(0.0)
STEADY = Pattern(azimuth_swing_rad=0.0, speed_swing=0.0)
UPRIGHT = np.zeros(6)


def quantity(*value: float) -> Quantity:
    return Quantity(meaning="test", value=value, unit="", tag="E", source="test")


def neutral(vehicle: Vehicle) -> Vehicle:
    return replace(vehicle, buoyancy=vehicle.weight)


def balanced(vehicle: Vehicle) -> Vehicle:
    """Neutral, with all centres in the origin: no axis moves another while it moves alone."""
    centre = quantity(0.0, 0.0, 0.0)
    return replace(neutral(vehicle), centre_of_gravity=centre, centre_of_buoyancy=centre)


def free(vehicle: Vehicle) -> Vehicle:
    """Without drag."""
    none = (quantity(0.0, 0.0, 0.0, 0.0, 0.0, 0.0),)
    return replace(vehicle, drag_linear=none, drag_quadratic=none)


def energy(plant: Plant) -> float:
    mass = plant.vehicle.mass_rigid() + plant.vehicle.mass_added()
    return 0.5 * float(plant.state[7:13] @ mass @ plant.state[7:13])


def coasting(plant: Plant, seconds: float, command: Array | None = None) -> Plant:
    count = len(plant.vehicle.thrusters)
    plant.advance(0, np.zeros(count) if command is None else command, round(seconds / plant.step_s))
    return plant


@pytest.mark.parametrize(
    ("command", "axis"),
    [
        ([0.5, 0.5, 0.0, 0.0, 0.0], 0),
        ([0.0, 0.0, 0.0, 0.0, 0.7], 1),
        ([0.0, 0.0, 0.6, 0.6, 0.0], 2),
        ([0.0, 0.0, -0.6, 0.6, 0.0], 4),
        ([0.4, -0.4, 0.0, 0.0, 0.0], 5),
    ],
)
@pytest.mark.parametrize("name", ["girona500", "girona500-uwsim"])
def test_terminal_speed_is_where_drag_equals_thrust(
    name: str, command: list[float], axis: int
) -> None:
    vehicle = balanced(load(name))
    plant = Plant(vehicle, STILL)

    coasting(plant, 400.0, np.array(command))
    push = (vehicle.allocation() @ plant.thrust())[axis]
    linear, quadratic = vehicle.linear_drag()[axis], vehicle.quadratic_drag()[axis]
    root = np.sqrt(linear**2 + 4.0 * quadratic * abs(push))

    expected = np.sign(push) * (root - linear) / (2.0 * quadratic)
    assert abs(push) > 1.0
    assert plant.velocity()[axis] == pytest.approx(expected, rel=0.005)


def test_full_speeds_are_those_of_the_real_vehicle() -> None:
    """COLA2's open-loop limits: 1.0 m/s ahead, 0.4 m/s sideways, with the published drag."""
    plant = Plant(balanced(load("girona500")), STILL)

    ahead = coasting(plant, 100.0, np.array([1.0, 1.0, 0.0, 0.0, 0.0])).velocity()[0]
    plant.reset(UPRIGHT)
    sideways = coasting(plant, 100.0, np.array([0.0, 0.0, 0.0, 0.0, 1.0])).velocity()[1]

    assert ahead == pytest.approx(1.02, abs=0.01)
    assert sideways == pytest.approx(0.385, abs=0.01)


@pytest.mark.parametrize("name", VEHICLES)
def test_righting_period_is_that_of_the_linear_pendulum(name: str) -> None:
    vehicle = free(neutral(load(name)))
    mass = vehicle.mass_rigid() + vehicle.mass_added()
    lever = vehicle.centre_of_gravity.value[2] - vehicle.centre_of_buoyancy.value[2]
    # Sway is free as well, so roll swings about the axis where it takes the least inertia.
    inertia = mass[3, 3] - mass[1, 3] ** 2 / mass[1, 1]
    expected = 2.0 * np.pi * np.sqrt(inertia / (vehicle.weight.scalar * lever))
    plant = Plant(vehicle, STILL, step_s=0.001)
    plant.reset(np.array([0.0, 0.0, 0.0, 0.01, 0.0, 0.0]))

    rolls = np.array([coasting(plant, 0.001).pose()[3] for _ in range(round(expected * 2e3) + 99)])

    rising = np.nonzero((rolls[:-1] < 0.0) & (rolls[1:] >= 0.0))[0]
    assert (rising[1] - rising[0]) * 0.001 == pytest.approx(expected, rel=0.002)


def test_a_neutral_vehicle_stays_where_it_is() -> None:
    plant = Plant(neutral(load("girona500")), STILL)
    plant.reset(np.array([1.0, 2.0, 3.0, 0.0, 0.0, 0.5]))

    coasting(plant, 60.0)

    assert plant.pose() == pytest.approx([1.0, 2.0, 3.0, 0.0, 0.0, 0.5], abs=1e-12)


def test_the_real_vehicle_rises_with_its_ten_newtons() -> None:
    vehicle = load("girona500")
    plant = coasting(Plant(vehicle, STILL), 120.0)
    linear, quadratic = vehicle.linear_drag()[2], vehicle.quadratic_drag()[2]

    speed = (np.sqrt(linear**2 + 4.0 * quadratic * 10.0) - linear) / (2.0 * quadratic)

    assert plant.velocity()[2] == pytest.approx(-speed, rel=0.005)


@pytest.mark.parametrize("name", VEHICLES)
def test_the_first_acceleration_is_force_over_mass_plus_added_mass(name: str) -> None:
    vehicle = balanced(load(name))
    effective = np.diag(vehicle.mass_rigid() + vehicle.mass_added())
    count = len(vehicle.thrusters)
    thrust = 5.0 * np.sin(np.arange(count) + 1.0)
    plant = Plant(vehicle, STILL, step_s=1e-4)
    plant.state[13:] = thrust

    plant.advance(0, np.zeros(count), 1)

    expected = vehicle.allocation() @ thrust / effective
    assert plant.velocity() / 1e-4 == pytest.approx(expected, rel=2e-3, abs=1e-6)


@pytest.mark.slow
@given(start=arrays(np.float64, 6, elements=st.floats(-1.0, 1.0)))
@pytest.mark.parametrize("name", VEHICLES)
def test_without_thrust_motion_only_decays(name: str, start: Array) -> None:
    plant = Plant(balanced(load(name)), STILL)
    plant.state[7:13] = start

    energies = [energy(plant), *(energy(coasting(plant, 0.05)) for _ in range(40))]

    assert np.all(np.diff(energies) <= 1e-9)


@pytest.mark.slow
@given(start=arrays(np.float64, 6, elements=st.floats(-0.5, 0.5)))
def test_without_drag_energy_and_momentum_are_conserved(start: Array) -> None:
    plant = Plant(free(balanced(load("girona500"))), STILL)
    plant.state[7:13] = start
    before = energy(plant)

    coasting(plant, 20.0)

    assert energy(plant) == pytest.approx(before, rel=1e-6, abs=1e-12)


@pytest.mark.parametrize("name", VEHICLES)
def test_a_drifting_vehicle_reaches_the_speed_of_the_water(name: str) -> None:
    current = Current(0.3, pattern=replace(STEADY, azimuth_rad=2.0))
    plant = Plant(neutral(load(name)), current)

    coasting(plant, 2000.0)
    yaw = plant.pose()[5]
    over_ground = plant.velocity()

    assert plant.current_world() == pytest.approx([-0.3 * np.cos(2), -0.3 * np.sin(2), 0.0])
    forward = over_ground[0] * np.cos(yaw) - over_ground[1] * np.sin(yaw)
    starboard = over_ground[0] * np.sin(yaw) + over_ground[1] * np.cos(yaw)
    assert [forward, starboard] == pytest.approx(plant.current_world()[:2], abs=0.004)


def test_a_neutral_vehicle_follows_accelerating_water() -> None:
    """In the water's frame nothing happens, whatever the water does: no drag, no spin."""
    vehicle = balanced(load("girona500"))
    plant = Plant(vehicle, Current(0.4, rng=streams(1, 0, 0).gust))
    plant.reset(UPRIGHT)
    plant.state[7:9] = plant.current_world()[:2]

    coasting(plant, 100.0)

    assert plant.velocity()[:2] == pytest.approx(plant.current_world()[:2], abs=1e-6)
    assert plant.velocity()[3:] == pytest.approx(np.zeros(3), abs=1e-6)


def test_physics_is_invariant_under_rotation_about_the_vertical() -> None:
    paths = []
    for yaw in (0.0, 1.2):
        current = Current(0.3, pattern=Pattern(azimuth_rad=yaw))
        plant = Plant(load("girona500"), current)
        plant.reset(np.array([0.0, 0.0, 0.0, 0.0, 0.0, yaw]))
        coasting(plant, 20.0, np.array([0.5, 0.4, 0.1, 0.2, 0.3]))
        paths.append(plant.velocity())

    assert paths[0] == pytest.approx(paths[1], abs=1e-12)


def test_the_body_force_balances_drag() -> None:
    vehicle = balanced(load("girona500-uwsim"))
    pattern = Pattern(law="force", azimuth_swing_rad=0.0, speed_swing=0.0)
    plant = Plant(vehicle, Current(0.4, pattern=pattern))

    coasting(plant, 100.0)

    push = 410.0 * 0.134 * 0.4**2
    assert plant.velocity()[1] == pytest.approx(np.sqrt(push / 148.0), rel=1e-6)
    assert plant.current_world() == pytest.approx([0.0, 0.4, 0.0])


def test_thrust_follows_the_command_with_its_time_constant() -> None:
    plant = Plant(load("girona500-uwsim"), STILL)

    coasting(plant, 0.2, np.array([1.0, 0.0, 0.0, 0.0, -0.5]))

    share = 1.0 - np.exp(-1.0)
    assert plant.thrust()[0] == pytest.approx(153.8 * share, rel=1e-3)
    assert plant.thrust()[4] == pytest.approx(-153.8 / 4.0 * share, rel=1e-3)


@given(
    pose=st.tuples(
        *[st.floats(-100.0, 100.0)] * 3,
        st.floats(-3.1, 3.1),
        st.floats(-1.5, 1.5),
        st.floats(-3.1, 3.1),
    )
)
def test_a_reset_vehicle_has_the_given_pose(pose: tuple[float, ...]) -> None:
    plant = Plant(load("girona500"), STILL)

    plant.reset(np.array(pose))

    assert plant.pose() == pytest.approx(np.array(pose), abs=1e-12)


def test_a_reset_clears_all_state() -> None:
    plant = Plant(load("girona500"), STILL)
    fresh = plant.state.copy()

    coasting(plant, 5.0, np.full(5, 0.5))
    plant.reset(UPRIGHT)

    assert np.array_equal(plant.state, fresh)


def test_a_command_that_is_not_a_number_is_refused() -> None:
    plant = Plant(load("girona500"), STILL)

    with pytest.raises(ValueError, match="must be numbers"):
        plant.advance(0, np.array([0.0, 0.0, np.nan, 0.0, 0.0]), 1)


def test_a_command_for_another_vehicle_is_refused() -> None:
    plant = Plant(load("girona500"), STILL)

    with pytest.raises(ValueError, match=r"shape \(5,\), not"):
        plant.advance(0, np.zeros(8), 1)


def test_a_read_only_command_is_accepted() -> None:
    states = []
    for writeable in (True, False):
        plant, command = Plant(load("girona500"), STILL), np.full(5, 0.3)
        command.flags.writeable = writeable
        plant.advance(0, command, 10)
        states.append(plant.state.tobytes())

    assert states[0] == states[1]


def test_a_plant_refuses_to_run_beyond_its_gust() -> None:
    plant = Plant(load("girona500"), Current(0.2, rng=streams(1, 0, 0).gust, duration_s=2.0))

    plant.advance(0, np.zeros(5), 200)
    with pytest.raises(ValueError, match=r"drawn for only 2\.0 s"):
        plant.advance(200, np.zeros(5), 5)


COMPILED = """
import numpy as np
from seamark.sim.numerics import random_streams
from seamark.sim.physics import contact, current, dynamics, terrain, thrusters
from seamark.sim.multibody import hull
from seamark.sim.physics.plant import Plant, warm_up
from seamark.sim.vehicles import load

def compiled():
    modules = (terrain, contact, current, dynamics, hull, thrusters)
    found = {f"{m.__name__}.{k}": v for m in modules for k, v in vars(m).items()}
    return {k: len(v.signatures) for k, v in found.items() if hasattr(v, "py_func")}

warm_up()
hull.warm_up()
before = compiled()
for name in ("girona500-uwsim", "bluerov2-heavy"):
    vehicle = load(name)
    mounds = terrain.draw_relief(random_streams.streams(1, 0, 0).bottom, height_m=0.3, flat_m=0.5)
    ground = terrain.Bottom(3.0, mounds)
    touching = contact.Contact(vehicle, ground, engine=hull.Hull)
    law = current.Pattern(law="force")
    plant = Plant(vehicle, current.Current(0.2, pattern=law), contact=touching)
    plant.reset(np.array([0, 0, 2.6, 0, 0, 0]))
    plant.advance(0, np.zeros(len(vehicle.thrusters)), 20)
    plant.pose(), plant.current_world(), ground.sound(plant.pose().tolist())
    touching.close()
print(before == compiled(), min(before["seamark.sim.physics.dynamics.advance_held"], 1))
"""


@pytest.mark.slow
def test_after_warming_up_nothing_is_left_to_compile() -> None:
    assert printed(COMPILED).split() == ["True", "1"]


def test_the_acceleration_is_the_rate_of_change_of_the_velocity() -> None:
    plant = Plant(load("girona500"), Current(0.4), step_s=1e-4)
    plant.reset(np.array([0.0, 0.0, 2.0, 0.05, -0.03, 0.4]))
    plant.advance(0, np.full(5, 0.4), 500)

    said, before = plant.acceleration(), plant.velocity()
    plant.advance(500, np.full(5, 0.4), 1)

    assert said == pytest.approx((plant.velocity() - before) / 1e-4, rel=1e-3, abs=1e-5)


def test_the_gain_of_a_thruster_multiplies_its_steady_thrust_alone() -> None:
    command, gains = np.full(5, 0.6), (1.0, 0.5, 1.1, 1.0, 0.0)
    nominal = Plant(load("girona500"), STILL)
    weak = Plant(load("girona500"), STILL, thruster_gains=gains)

    nominal.advance(0, command, 20)
    weak.advance(0, command, 20)

    assert weak.thrust() == pytest.approx(nominal.thrust() * gains)
