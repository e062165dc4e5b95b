"""What a trial of an intervention draws beside what it works on: its tilt and the water."""

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from seamark.sim.benchmarks.intervention.experiment import Intervention
from seamark.sim.benchmarks.intervention.tilt import Tilt
from seamark.sim.registry import benchmark

SEED = 2026
TRIALS = range(30)
INTERVENTIONS = ("recover-v1", "valve-v1", "connect-v1")


def intervention(name: str) -> Intervention[Any]:
    experiment = benchmark(name).load()
    assert isinstance(experiment, Intervention)
    return experiment


def config_of(name: str, **settings: float) -> Any:
    return benchmark(name).read({"levels": [0.1], "level_duration_s": 2.0, **settings})


@pytest.mark.parametrize(("angle", "axis", "heading"), [(0.14, 0.0, 0.0), (0.2, 2.5, -3.0)])
def test_a_tilt_turns_what_has_a_heading_about_a_level_axis(
    angle: float, axis: float, heading: float
) -> None:
    tilt = Tilt(angle_rad=angle, axis_rad=axis)
    level = Rotation.from_euler("z", heading)
    about = Rotation.from_rotvec(angle * np.array([np.cos(axis), np.sin(axis), 0.0]))

    turned = Rotation.from_euler("ZYX", tilt.attitude(heading)[::-1])

    assert tilt.matrix() == pytest.approx(about.as_matrix(), abs=1e-12)
    assert turned.as_matrix() == pytest.approx((about * level).as_matrix(), abs=1e-12)


@pytest.mark.parametrize("name", INTERVENTIONS)
def test_trials_tilt_their_work_by_up_to_the_spread_about_any_axis(name: str) -> None:
    experiment, config = intervention(name), config_of(name)
    tilts = [
        experiment.plan(config, seed=SEED, trial=trial).conditions["work"]["tilt"]
        for trial in TRIALS
    ]

    angles = [tilt["angle_rad"] for tilt in tilts]
    axes = [tilt["axis_rad"] for tilt in tilts]
    assert all(0.0 <= angle <= config.tilt_spread_rad for angle in angles)
    assert max(angles) > 0.8 * config.tilt_spread_rad
    assert min(axes) < -2.0
    assert max(axes) > 2.0


@pytest.mark.slow
@pytest.mark.parametrize("name", INTERVENTIONS)
def test_the_face_that_is_tracked_is_tilted_as_its_trial_says(name: str) -> None:
    experiment, config = intervention(name), config_of(name)

    for trial in range(4):
        drawn = experiment.drawn_work(config, seed=SEED, trial=trial)["tilt"]
        world = experiment.world(config, seed=SEED, trial=trial, level=0)
        plant = world.plant
        motion = [plant.pose(), plant.velocity(), plant.joints(), plant.joint_rates()]
        plant.measure_work()
        world.camera.truth(np.concatenate([*motion, plant.work[:14]]))
        first, second, third, _ = world.camera._points[:4]
        normal = np.cross(second - first, third - second)
        angle = np.arccos(normal[2] / np.linalg.norm(normal))
        assert angle == pytest.approx(drawn["angle_rad"], abs=1e-6)
        down = np.array([normal[0], normal[1]]) / np.linalg.norm(normal[:2])
        across = np.array([-np.sin(drawn["axis_rad"]), np.cos(drawn["axis_rad"])])
        assert abs(down @ across) == pytest.approx(1.0, abs=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("name", INTERVENTIONS)
def test_suspended_matter_adds_its_optical_depth_to_the_water_of_the_settings(name: str) -> None:
    experiment, config = intervention(name), config_of(name)
    clear = config_of(name, turbidity_spread=0.0)

    depths = []
    for trial in TRIALS:
        drawn = experiment.plan(config, seed=SEED, trial=trial).conditions["turbidity"]
        turbid, pure = (
            experiment.camera(one, seed=SEED, trial=trial, level=0).water.attenuation
            for one in (config, clear)
        )
        more = np.subtract(turbid, pure) * config.altitude_m
        assert more.tolist() == pytest.approx([drawn] * 3)
        depths.append(drawn)

    assert all(0.0 <= depth <= config.turbidity_spread for depth in depths)
    assert max(depths) > 0.8 * config.turbidity_spread


@pytest.mark.parametrize("name", INTERVENTIONS)
def test_programs_are_not_told_the_tilt_and_the_turbidity(name: str) -> None:
    told = config_of(name).for_program()

    assert not {"tilt_spread_rad", "turbidity_spread", "tilt", "turbidity"} & set(told)


@pytest.mark.parametrize("name", INTERVENTIONS)
def test_other_conditions_are_the_same_without_tilt_and_turbidity(name: str) -> None:
    experiment = intervention(name)
    with_both, without = (
        experiment.plan(config, seed=SEED, trial=3).conditions
        for config in (config_of(name), config_of(name, tilt_spread_rad=0, turbidity_spread=0))
    )

    for conditions in (with_both, without):
        conditions["work"].pop("tilt")
        conditions.pop("turbidity")
    assert with_both == without
