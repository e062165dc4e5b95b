"""The sonar of a vehicle that docks sees the dock."""

import math

import numpy as np
import pytest

from seamark.sim import registry
from seamark.sim.benchmarks.reference_results import configuration_digest, of_benchmark
from seamark.sim.engine.vehicle_sonar import build_sonar
from seamark.sim.numerics.random_streams import streams

ENTRY = registry.benchmark("dock-v1")
SEED = 3


def test_without_a_sonar_the_configuration_of_dock_v1_is_stored_as_it_was() -> None:
    assert not [name for name in ENTRY.read({}).model_dump() if "sonar" in name]
    assert all(
        configuration_digest(ENTRY, name) == result.configuration
        for name, result in of_benchmark(ENTRY).items()
    )


@pytest.mark.slow
@pytest.mark.parametrize("trial", [0, 1])
def test_the_dock_returns_from_where_it_stands(trial: int) -> None:
    settings = {"sonar": "forward", "sonar_range_m": 20.0, "levels": [0.0]}
    config = ENTRY.read(settings).for_trial(trial)
    camera = ENTRY.load().camera(config, seed=SEED, trial=trial, level=0)
    sonar = build_sonar(config, camera, streams(SEED, trial, 0))
    assert sonar is not None
    north, east, _top = camera.target.top_centre()
    away, height = 8.0, 3.0
    pose = np.array([north - away, east, camera.target.seabed_m - height, 0.0, 0.0, 0.0])

    seen, turned = (
        np.mean([np.square(sonar.image(at, k), dtype=np.float64) for k in range(8)], axis=0)
        for at in (pose, pose + np.array([0.0, 0.0, 0.0, 0.0, 0.0, 3.0]))
    )

    row, column = np.unravel_index(int(seen.argmax()), seen.shape)
    assert (row + 0.5) * sonar.device.bin_m == pytest.approx(math.hypot(away, height), abs=1.5)
    assert abs(sonar.device.azimuth_rad(float(column))) < math.atan(1.2 / (away - 1.0))
    assert seen.max() > 200.0**2 > 4.0 * turned[:, 40:216].mean()
