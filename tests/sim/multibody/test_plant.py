"""A vehicle with an arm as a plant: it lies level, moves its joints, and its gauges read forces."""

import numpy as np
import pytest

from seamark.sim.multibody.assembly import Mounting, fixed_box
from seamark.sim.multibody.plant import ArmedPlant, Readings
from seamark.sim.physics.constants import WATER_DENSITY
from seamark.sim.physics.contact import TargetBox
from seamark.sim.physics.current import Current, Pattern
from seamark.sim.physics.plant import Plant
from seamark.sim.physics.terrain import Bottom
from seamark.sim.registry import ARMS, VEHICLES
from seamark.sim.vehicles import STANDARD_GRAVITY, load
from seamark.sim.vehicles.linkage_reading import load_linkage

STEP_S = 0.01
BEYOND = ("wrist", "jaw port", "jaw starboard")  # its force sensor
CLOSING = (0.0, 0.0, 0.0, 0.0, -0.5)
FITTING = [(vehicle, arm) for vehicle in VEHICLES for arm in load(vehicle).mounts]


def armed(
    vehicle: str = "bluerov2-heavy-v2",
    arm: str = "alpha-like",
    *,
    bottom: Bottom | None = None,
    things: tuple[Mounting, ...] = (),
    speed: float = 0.0,
) -> ArmedPlant:
    carrier = load(vehicle)
    mounting = Mounting(linkage=load_linkage(arm), place=carrier.mounts[arm], on_vehicle=True)
    current = Current(speed, rng=np.random.Generator(np.random.PCG64(0)))
    plant = ArmedPlant(carrier, [mounting, *things], current, bottom, step_s=STEP_S)
    plant.reset(np.zeros(6))
    return plant


def advance(plant: ArmedPlant, seconds: float, speeds: tuple[float, ...] = ()) -> None:
    first = plant._step
    plant.drive(speeds)
    plant.advance(first, np.zeros(len(plant.vehicle.thrusters)), round(seconds / STEP_S))


def test_every_arm_has_a_vehicle_that_carries_it() -> None:
    assert {arm for _vehicle, arm in FITTING} == set(ARMS)


@pytest.mark.parametrize(("vehicle", "arm"), FITTING)
def test_a_vehicle_that_is_trimmed_for_its_arm_lies_as_without(vehicle: str, arm: str) -> None:
    bare = Plant(load(vehicle), Current(0.0), step_s=STEP_S)
    plant = armed(vehicle, arm)

    bare.advance(0, np.zeros(len(bare.vehicle.thrusters)), 100)
    home = plant.joints()
    advance(plant, 1.0)

    # One that rises or sinks is turned a little by the inertia and the drag of its arm.
    neutral = bare.vehicle.weight.scalar == bare.vehicle.buoyancy.scalar
    assert plant.pose()[3:] == pytest.approx(bare.pose()[3:], abs=1e-6 if neutral else 0.02)
    assert plant.velocity()[2] == pytest.approx(bare.velocity()[2], rel=0.2, abs=1e-6)
    assert plant.joints() == pytest.approx(home, abs=2e-3)


@pytest.mark.slow
def test_an_arm_that_is_drawn_in_lifts_the_bow_and_stretched_again_no_more() -> None:
    plant = armed()

    advance(plant, 30.0)
    before = plant.pose()[4]
    advance(plant, 2.0, (0.0, 0.5))
    advance(plant, 30.0)
    drawn_in = plant.pose()[4]
    advance(plant, 2.0, (0.0, -0.5))
    advance(plant, 30.0)

    assert drawn_in > before + 0.1
    assert plant.joints()[1] == pytest.approx(1.0, abs=5e-3)
    assert plant.pose()[4] == pytest.approx(before, abs=5e-3)


def test_a_joint_turns_at_the_speed_that_is_asked_for_up_to_its_fastest() -> None:
    plant = armed()

    advance(plant, 1.0, (0.2,))
    slow = plant.joint_rates()[0]
    advance(plant, 1.0, (99.0,))

    assert slow == pytest.approx(0.2, abs=1e-3)
    assert plant.joint_rates()[0] == pytest.approx(0.5, abs=1e-3)


def test_the_force_sensor_carries_the_weight_of_what_is_beyond_it() -> None:
    plant = armed()
    hand = [link.body for link in load_linkage("alpha-like").links if link.name in BEYOND]
    weights = [body.weights(WATER_DENSITY.scalar, STANDARD_GRAVITY)[0] for body in hand if body]

    advance(plant, 0.5)
    advance(plant, 0.05)

    force = plant.readings.wrench[:3]
    assert sum(weights) > 0.5
    assert np.linalg.norm(force) == pytest.approx(sum(weights), rel=0.02)


def test_jaws_that_close_feel_each_other_and_nothing_from_outside() -> None:
    plant = armed()

    advance(plant, 3.0, CLOSING)
    advance(plant, 0.05, CLOSING)

    wrist, port, starboard = plant.readings.touch_n
    assert wrist == 0.0
    assert port == pytest.approx(starboard)
    assert 10.0 < port < 200.0
    assert plant.readings.peak_n[0] == 0.0
    assert abs(plant.readings.effort[4]) == pytest.approx(5.0, rel=1e-6)


def test_an_arm_that_is_lowered_on_a_box_is_pushed_back_and_none_above_it_is() -> None:
    def pushed(top_m: float) -> Readings:
        box = TargetBox(centre=(0.9, 0.0, top_m + 0.2), size=(1.4, 0.4, 0.4), fixed=True)
        plant = armed(things=(fixed_box(box),))
        advance(plant, 3.0, (0.0, -0.3))
        return plant.readings

    touching, clear = pushed(0.25), pushed(2.0)

    assert touching.peak_n[0] > 2.0
    assert touching.touch_n.sum() > 0.2
    assert clear.peak_n[0] == clear.touch_n.sum() == 0.0


def test_a_hull_on_the_bottom_is_pushed_and_its_arm_in_the_air_is_not() -> None:
    plant = armed("girona500", "hook", bottom=Bottom(1.2))
    commands = np.zeros(len(plant.vehicle.thrusters))
    heave = plant.vehicle.allocation()[2]
    commands[:] = 0.6 * np.sign(np.where(abs(heave) > 0.5, heave, 0.0))

    plant.drive((0.5, 0.3))  # up, out of the way
    plant.advance(0, 0.0 * commands, 300)
    plant.drive(())
    plant.advance(300, commands, 1000)
    plant.advance(1300, commands, 5)

    assert plant.readings.hull_n[0] > 3.0
    assert plant.contact_force() == plant.readings.hull_n[0]
    assert plant.readings.peak_n[0] == 0.0


def test_a_plant_that_is_reset_moves_as_a_new_one() -> None:
    first, again = armed(speed=0.2), armed(speed=0.2)
    advance(first, 2.0, (0.1, 0.2, -0.3, 0.4, -0.1))
    first.reset(np.zeros(6))

    for plant in (first, again):
        plant.drive((0.0, 0.1))
        plant.advance(0, np.full(8, 0.2), 200)

    assert first.state.tobytes() == again.state.tobytes()
    assert first.mechanism.q.tobytes() == again.mechanism.q.tobytes()


def test_how_steps_are_split_over_calls_makes_no_difference() -> None:
    whole, split = armed(speed=0.3), armed(speed=0.3)

    advance(whole, 1.0, (0.1, 0.2))
    for _ in range(20):
        advance(split, 0.05, (0.1, 0.2))

    assert whole.state.tobytes() == split.state.tobytes()


def test_a_current_that_pushes_instead_of_flowing_is_refused() -> None:
    carrier = load("bluerov2-heavy-v2")
    pattern = Pattern(law="force", force_share=1.0)
    current = Current(0.1, pattern=pattern, rng=np.random.Generator(np.random.PCG64(0)))

    with pytest.raises(ValueError, match="not the force law"):
        ArmedPlant(carrier, [], current, None, step_s=STEP_S)


def test_a_command_that_is_not_a_number_is_refused() -> None:
    plant = armed()

    with pytest.raises(ValueError, match="must be numbers"):
        plant.advance(0, np.full(8, np.nan), 1)
