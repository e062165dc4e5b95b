"""A workpiece is measured where the mechanism has it, and rendered again from what was measured."""

from dataclasses import replace

import numpy as np
import pytest

from seamark.sim.benchmarks.intervention.box import GRIP_M, RAISED_M, BoxDraw, workpiece
from seamark.sim.benchmarks.intervention.tilt import Tilt
from seamark.sim.multibody.assembly import Mounting
from seamark.sim.multibody.plant import ArmedPlant
from seamark.sim.multibody.posture import Posture
from seamark.sim.multibody.workpiece import MEASURED, MOTION, Workpiece
from seamark.sim.physics.current import Current
from seamark.sim.physics.terrain import Bottom
from seamark.sim.vehicles import STANDARD_GRAVITY, load
from seamark.sim.vehicles.linkage_reading import load_linkage

VEHICLE, ARM = "girona500", "arm-5e-like"
HEADING = 0.4
WEIGHT_N = (14.0 - 0.012 * 1025.0) * STANDARD_GRAVITY  # about, by its file


def plant_with(work: Workpiece) -> ArmedPlant:
    vehicle = load(VEHICLE)
    arm = Mounting(linkage=load_linkage(ARM), place=vehicle.mounts[ARM], on_vehicle=True)
    current = Current(0.0, rng=np.random.Generator(np.random.PCG64(0)))
    plant = ArmedPlant(vehicle, [arm], current, Bottom(5.0), step_s=0.01, workpiece=work)
    plant.reset(np.array([-1.5, 0.2, 3.0, 0.0, 0.0, 0.3]))
    return plant


def advanced(plant: ArmedPlant, steps: int) -> None:
    plant.advance(plant._step, np.zeros(len(plant.vehicle.thrusters)), steps)
    plant.measure_work()


@pytest.mark.parametrize(("angle", "axis"), [(0.0, 0.0), (0.14, 2.0), (0.25, -0.7)])
def test_a_box_that_lies_on_a_tilted_stone_stays_and_is_borne_by_it_alone(
    angle: float, axis: float
) -> None:
    tilt = Tilt(angle_rad=angle, axis_rad=axis)
    plant = plant_with(workpiece(BoxDraw(heading_rad=HEADING, friction_factor=0.7, tilt=tilt)))

    advanced(plant, 300)
    before = plant.work[:6].copy()
    advanced(plant, 300)

    middle = np.array([0.0, 0.0, 5.0 - RAISED_M]) + tilt.matrix() @ [0.0, 0.0, -0.1]
    lying = [*middle, *tilt.attitude(HEADING + 0.5 * np.pi)]
    assert plant.work[:6] == pytest.approx(lying, abs=1e-4)
    assert plant.work[:6] == pytest.approx(before, abs=1e-6)
    arm, hull, rest = plant.readings.work_n
    assert (arm, hull) == (0.0, 0.0)
    assert rest == pytest.approx(WEIGHT_N, rel=0.5)
    assert plant.readings.push.tolist() == [0.0, 0.0, 0.0]


def test_a_heavier_box_weighs_more_on_its_stone() -> None:
    light, heavy = (plant_with(workpiece(BoxDraw(mass_kg=mass))) for mass in (-0.4, 0.4))

    for plant in (light, heavy):
        advanced(plant, 300)

    more = heavy.readings.work_n[2] - light.readings.work_n[2]
    assert more == pytest.approx(0.8 * STANDARD_GRAVITY, rel=0.1)


def test_the_reach_is_the_distance_of_the_tool_from_the_grip() -> None:
    plant = plant_with(workpiece(BoxDraw(heading_rad=HEADING)))

    plant.measure_work()

    tool, grip = plant.work[15:18], np.array([0.0, 0.0, 4.9 - RAISED_M]) + GRIP_M
    assert len(plant.work) == MEASURED
    assert plant.work[14] == pytest.approx(np.linalg.norm(tool - grip))


def test_what_was_measured_places_the_links_again_where_they_were() -> None:
    work = workpiece(BoxDraw(heading_rad=HEADING))
    plant = plant_with(work)
    advanced(plant, 50)
    posture = Posture(plant.assembly, work.link)
    number = plant.assembly.mechanism.number(work.link)

    motion = [
        plant.pose(),
        plant.velocity(),
        plant.joints(),
        plant.joint_rates(),
        plant.work[:MOTION],
    ]
    turns, points, twists = posture.place(np.concatenate(motion))

    frames = plant._parts.frames
    assert points[number] == pytest.approx(plant.work[:3], abs=1e-12)
    assert turns[number] == pytest.approx(frames.rotation[number], abs=1e-9)
    assert twists[number] == pytest.approx(plant.work[6:12], abs=1e-12)


def test_an_arm_without_a_tool_cannot_work_on_anything() -> None:
    vehicle, linkage = load(VEHICLE), load_linkage(ARM)
    blunt = Mounting(
        linkage=replace(linkage, tool=None),
        place=vehicle.mounts[ARM],
        on_vehicle=True,
    )
    current = Current(0.0, rng=np.random.Generator(np.random.PCG64(0)))

    with pytest.raises(ValueError, match="needs a tool centre point"):
        ArmedPlant(vehicle, [blunt], current, None, step_s=0.01, workpiece=workpiece(BoxDraw()))
