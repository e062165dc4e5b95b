"""A stored configuration stays readable, whatever today's version accepts."""

import json

import numpy as np
import pytest

from seamark.sim.benchmarks.benchmark import Benchmark
from seamark.sim.engine.replay import Replay
from seamark.sim.recording.telemetry import WIDTH
from seamark.sim.registry import BENCHMARKS, benchmark
from seamark.sim.settings import grid
from seamark.sim.settings.configuration import Configuration
from seamark.sim.settings.refusal import ConfigurationInvalid
from seamark.sim.settings.setting import schema_extras


@pytest.mark.parametrize("name", BENCHMARKS)
def test_a_valid_configuration_is_restored_as_it_was(name: str) -> None:
    entry = benchmark(name)
    known = {"warp": "affine", "colour": True, "lookahead_m": 0.7}
    own = {key: value for key, value in known.items() if key in entry.configuration.settings()}
    assert own
    config = entry.read({**entry.quick_settings, "level_duration_s": 4.0, **own})

    stored = json.loads(json.dumps(config.model_dump(mode="json")))

    assert entry.restore(stored) == config


def test_a_value_outside_todays_range_is_kept(currents: Benchmark) -> None:
    values = {"kp": 99.0, "levels": [3, 1], "tracker": "template_2021"}
    with pytest.raises(ConfigurationInvalid):
        currents.read(values)

    restored = currents.restore(values).model_dump()

    assert {name: restored[name] for name in values} == values | {"levels": (3.0, 1.0)}


def test_an_unknown_setting_is_ignored_and_a_missing_one_has_its_default(
    currents: Benchmark,
) -> None:
    restored = currents.restore({"removed_setting": 1, "kp": 0.7})

    assert restored == currents.read({"kp": 0.7})


def test_a_value_of_another_type_becomes_the_default(currents: Benchmark) -> None:
    assert currents.restore({"levels": "none", "kp": {"x": 1}}) == currents.read({})


def test_whole_numbers_of_a_stored_document_become_floats(currents: Benchmark) -> None:
    restored = currents.restore({"kp": 1, "levels": [0, 1]}).model_dump()

    assert (type(restored["kp"]), restored["levels"]) == (float, (0.0, 1.0))
    assert all(type(value) is float for value in restored["levels"])


@pytest.mark.parametrize("name", BENCHMARKS)
def test_pages_can_describe_a_run_whose_choices_no_longer_exist(name: str) -> None:
    entry = benchmark(name)
    choices = {
        setting: "no longer a choice"
        for setting, field in entry.configuration.settings().items()
        if "enum" in schema_extras(field)
    }
    config = entry.restore({**choices, **{f"loop{i}_values": [1] for i in (1, 2, 3)}})

    assert choices
    assert entry.charts_of(config)
    assert entry.headline_of(config).label
    assert entry.solution_label_of("no longer a controller", config.model_dump())
    assert config.level_metric().label
    assert len(grid.level_comments(config)) == len(config.level_values()) > 0
    assert config.exact() is not bool({"tracker", "detector"} & choices.keys())


def first_image(name: str, config: Configuration) -> np.ndarray:
    return Replay(name, config, lambda _trial: 3).frame(np.zeros(WIDTH)).grey()


@pytest.mark.parametrize(
    ("name", "rendered", "out_of_range"),
    [
        ("currents-v1", {"camera_noise_grey": 2.0}, {"kp": 99.0, "dvl_rate_hz": 7.0}),
        ("visibility-v1", {"camera_noise_grey": 2.0}, {"kp": 99.0, "reacquire_px": -5}),
    ],
)
def test_images_of_a_restored_run_are_those_of_its_stored_settings(
    name: str, rendered: dict[str, float], out_of_range: dict[str, float]
) -> None:
    entry = benchmark(name)

    image = first_image(name, entry.restore({**rendered, **out_of_range, "removed_setting": 1}))

    assert np.array_equal(image, first_image(name, entry.read(rendered)))
    assert not np.array_equal(image, first_image(name, entry.read({})))
