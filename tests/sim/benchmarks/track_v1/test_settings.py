"""track-v1 has the settings that it uses, and refuses the others."""

import pytest

from seamark.sim.registry import benchmark
from seamark.sim.settings.refusal import ConfigurationInvalid

ENTRY = benchmark("track-v1")


@pytest.mark.parametrize(
    ("name", "value"),
    [("tracker", "klt"), ("target", "plain"), ("range_from", "start"), ("start_error_px", 1.0)],
)
def test_a_setting_of_camera_or_tracker_is_none_of_this_benchmark(name: str, value: object) -> None:
    assert name not in ENTRY.schema()["properties"]
    with pytest.raises(ConfigurationInvalid) as refused:
        ENTRY.read({name: value})

    assert refused.value.errors == {
        name: f"{name} is not a setting of this benchmark; leave it out."
    }


def test_a_whole_stored_configuration_is_read_again() -> None:
    config = ENTRY.read({"levels": [0.3], "speed_m_s": 0.4})

    assert ENTRY.read(config.model_dump()) == config


def test_a_transceiver_cannot_be_at_least_farther_than_at_most() -> None:
    with pytest.raises(ConfigurationInvalid, match="boat_most_m"):
        ENTRY.read({"boat_least_m": 30.0, "boat_most_m": 20.0})


def test_a_program_is_not_told_the_current_nor_where_the_boat_is() -> None:
    told = ENTRY.read({}).for_program()

    assert "start_error_m" in told
    assert not {"levels", "current_azimuth_rad", "azimuth_spread_rad"} & set(told)
