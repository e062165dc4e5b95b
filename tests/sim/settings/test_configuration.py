"""Errors name the setting and its allowed range; the schema gives the form the same range."""

import contextlib
import copy
import math
from typing import Any

import jsonschema_rs
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from seamark.sim.benchmarks.benchmark import Benchmark
from seamark.sim.registry import BENCHMARKS, benchmark
from seamark.sim.settings.refusal import ConfigurationInvalid
from seamark.sim.vehicles import TAGS

CURRENTS = benchmark("currents-v1")


def errors_of(values: dict[str, Any]) -> dict[str, str]:
    with pytest.raises(ConfigurationInvalid) as caught:
        CURRENTS.read(values)
    return caught.value.errors


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"kp": -1}, ("kp", "from 0 to 5 1/s", "-1")),
        ({"kp": math.nan}, ("kp", "from 0 to 5 1/s", "nan")),
        ({"kp": "infinity"}, ("kp", "from 0 to 5 1/s")),
        ({"ki": True}, ("ki", "a number from 0 to 2", "True")),
        ({"levels": [0.2, 0.1]}, ("levels", "must increase")),
        ({"levels": [0.0, 3.0]}, ("levels", "from 0 to 1 m/s")),
        ({"levels": [0.0, math.nan]}, ("levels", "from 0 to 1 m/s")),
        ({"levels": []}, ("levels", "1 to 12 numbers")),
        ({"control_period_s": 0.033}, ("control_period_s", "whole multiple", "0.01 s", "0.033 s")),
        ({"control_period_s": 0.07}, ("level_duration_s", "whole multiple", "0.07 s")),
        ({"dvl_rate_hz": 7}, ("dvl_rate_hz", "whole multiple", "7 Hz")),
        ({"settle_s": 120}, ("settle_s", "shorter than a level of 120 s")),
        ({"tracker": "esn"}, ("tracker", "one of esm", "esn")),
        ({"vehicle": "submarine"}, ("vehicle", "girona500, girona500-uwsim")),
        ({"warp": ["affine"]}, ("warp", "translation, rt, srt, affine, homography")),
        ({"heading_hold": "perhaps"}, ("heading_hold", "true or false")),
        ({"camera_width_px": 320.5}, ("camera_width_px", "a whole number from 160 to 1280 px")),
        ({"altitude_m": 6}, ("altitude_m", "at most 4.18 m", "6 m")),
        ({"camera_focal_px": 5000}, ("camera_focal_px", "925 x 286 px", "640 x 480 px")),
        ({"start_error_px": 5}, ("start_error_px", "at most 2.9 px", "5 px")),
        ({"kpp": 1}, ("kpp", "is not a setting", "did you mean kp?")),
        ({"reference_limit_m_s": 0}, ("reference_limit_m_s", "above 0 up to 5 m/s")),
    ],
)
def test_an_invalid_value_is_rejected_with_its_range(
    values: dict[str, Any], words: tuple[str, ...]
) -> None:
    errors = errors_of(values)

    sentence = errors[words[0]]
    assert all(word in sentence for word in words), sentence
    assert sentence.endswith((".", "?"))


def test_all_invalid_settings_are_reported_at_once() -> None:
    assert set(errors_of({"kp": -1, "ki": "x", "tracker": "y"})) == {"kp", "ki", "tracker"}


def test_text_from_a_form_or_a_command_line_is_parsed_as_numbers() -> None:
    config = CURRENTS.read({"levels": "0, 0.2,0.4", "kp": "0.7", "heading_hold": "false"})

    dump = config.model_dump()
    assert (dump["levels"], dump["kp"], dump["heading_hold"]) == ((0.0, 0.2, 0.4), 0.7, False)


def test_a_single_level_needs_no_list() -> None:
    assert CURRENTS.read({"levels": "0.3"}).model_dump()["levels"] == (0.3,)


def test_the_papers_vehicle_sets_the_papers_models_and_each_can_be_changed() -> None:
    paper = CURRENTS.read({"vehicle": "girona500-uwsim", "heading_hold": True}).model_dump()

    assert (paper["current_law"], paper["velocity_law"]) == ("force", "paper")
    assert paper["heading_hold"] is True
    assert CURRENTS.read({}).model_dump()["current_law"] == "relative"


def test_a_configuration_read_again_is_the_same() -> None:
    config = CURRENTS.read({"vehicle": "girona500-uwsim", "kp": 0.3})

    assert CURRENTS.read(config.model_dump(mode="json")) == config


def test_a_ranked_run_has_the_benchmarks_scenario_and_the_users_solution() -> None:
    wish = CURRENTS.read({"levels": [0.0, 0.05], "kp": 0.9, "warp": "affine", "dvl_rate_hz": 20})

    ranked = CURRENTS.ranked(wish).model_dump()

    assert (ranked["kp"], ranked["warp"]) == (0.9, "affine")
    assert (ranked["levels"], ranked["dvl_rate_hz"]) == ((0.0, 0.1, 0.2, 0.3, 0.4), 5.0)


def test_ground_truth_instead_of_a_tracker_cannot_rank() -> None:
    with pytest.raises(ConfigurationInvalid) as caught:
        CURRENTS.ranked(CURRENTS.read({"tracker": "truth"}))

    assert set(caught.value.errors) == {"tracker"}


def test_the_schema_is_json_schema_2020_12_with_title_and_help_for_every_setting(
    currents: Benchmark,
) -> None:
    schema = currents.schema()

    jsonschema_rs.meta.validate(schema)
    for name, entry in schema["properties"].items():
        assert entry["title"], name
        assert entry["description"], name
        assert "default" in entry, name
        assert entry["x-role"] in ("scenario", "solution"), name
        assert entry["x-group"] in currents.groups, name
        assert set(entry.get("enum", [])) == set(entry.get("x-labels", {})), name


def test_defaults_and_presets_are_valid_under_the_schema(currents: Benchmark) -> None:
    schema = currents.schema()
    check = jsonschema_rs.validator_for(schema)
    defaults = {name: entry["default"] for name, entry in schema["properties"].items()}

    check.validate(defaults)
    for vehicle, values in schema["x-presets"]["vehicle"].items():
        check.validate(defaults | {"vehicle": vehicle} | values)
    assert currents.read(defaults) == currents.read({})


@pytest.mark.slow
@given(
    setting=st.sampled_from(
        [
            (name, key)
            for name in BENCHMARKS
            for key in sorted(benchmark(name).schema()["properties"])
        ]
    ),
    value=st.one_of(
        *(st.floats(0.0, 2.0), st.integers(0, 20), st.booleans(), st.lists(st.floats(0.0, 1.0))),
        *(st.floats(), st.integers(), st.text(max_size=5), st.lists(st.floats())),
    ),
)
@example(setting=("currents-v1", "kp"), value=1)
@example(setting=("currents-v2", "levels"), value=[0.0, 0.1])
def test_accepted_values_are_valid_under_the_schema(
    setting: tuple[str, str], value: object
) -> None:
    name, key = setting
    check = jsonschema_rs.validator_for(benchmark(name).schema())

    with contextlib.suppress(ConfigurationInvalid):
        check.validate(benchmark(name).read({key: value}).model_dump(mode="json"))


@pytest.mark.parametrize("name", BENCHMARKS)
def test_every_tagged_setting_names_its_source(name: str) -> None:
    properties = benchmark(name).schema()["properties"]

    tagged = {key: entry for key, entry in properties.items() if "x-tag" in entry}
    assert len(tagged) > 10
    assert [key for key, entry in tagged.items() if not entry["x-source"]] == []
    assert {entry["x-tag"] for entry in tagged.values()} <= set(TAGS)


def test_another_process_gets_a_refusal_with_its_messages() -> None:
    refusal = ConfigurationInvalid({"levels": "too many.", "arm": "unknown."})

    received = copy.copy(refusal)  # by the same protocol as to another process

    assert (str(received), received.errors) == (str(refusal), refusal.errors)
