"""dock-v1 has the settings that it uses, and refuses the others."""

import pytest

from seamark.sim.benchmarks.dock_v1.settings import keel_m
from seamark.sim.registry import benchmark
from seamark.sim.settings.refusal import ConfigurationInvalid
from seamark.sim.settings.two_vehicles import MEASURED
from seamark.sim.vehicles import load

ENTRY = benchmark("dock-v1")


@pytest.mark.parametrize("name", ["start_offset_m", "start_heading_rad", "start_error_px"])
def test_a_setting_of_a_start_above_the_target_is_none_of_this_benchmark(name: str) -> None:
    assert name not in ENTRY.schema()["properties"]
    with pytest.raises(ConfigurationInvalid, match=name):
        ENTRY.read({name: 0.1})


def test_a_whole_stored_configuration_is_read_again() -> None:
    config = ENTRY.read({"levels": [0.3], "turbidity_1_m": 0.4})

    assert ENTRY.read(config.model_dump()) == config


@pytest.mark.parametrize(
    ("settings", "name"),
    [
        ({"approach_least_m": 6.0, "approach_most_m": 5.0}, "approach_most_m"),
        ({"fix_period_s": 2.02}, "fix_period_s"),
        ({"contacts": "pybullet"}, "contacts"),
        ({"levels": [0.3, 0.2]}, "levels"),
    ],
)
def test_what_does_not_go_together_is_refused(settings: dict[str, object], name: str) -> None:
    with pytest.raises(ConfigurationInvalid) as refused:
        ENTRY.read(settings)

    assert name in refused.value.errors


@pytest.mark.parametrize("trial", [0, 1])
def test_a_program_is_told_the_dock_and_its_camera_but_neither_current_nor_start(
    trial: int,
) -> None:
    told = ENTRY.read({}).for_trial(trial).for_program()

    vehicle = load(MEASURED[trial])
    assert told["camera_mount_m"] == (0.0, 0.0, keel_m(vehicle))
    assert told["rails_m"] == 0.75
    assert told["marker_m"] == (0.3, 0.2, 0.1)
    assert not {"levels", "current_azimuth_rad", "azimuth_spread_rad"} & set(told)
