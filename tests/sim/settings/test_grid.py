"""Scene updaters nested into a grid: the order of its points, what each sets, what is invalid."""

import itertools
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from seamark.sim.benchmarks.currents_v1.definition import CurrentsConfiguration
from seamark.sim.benchmarks.station_keeping.experiment import StationKeeping
from seamark.sim.engine.program import BuiltIn
from seamark.sim.engine.summary import summarise
from seamark.sim.engine.trial import run_trial
from seamark.sim.recording.telemetry import INDEX, Rows
from seamark.sim.registry import benchmark
from seamark.sim.settings import grid
from seamark.sim.settings.grid import UPDATERS
from seamark.sim.settings.refusal import ConfigurationInvalid

LARGE = {"camera_noise", "altitude", "repeat"}  # updaters for which 0.1 is too little
QUICK = {"level_duration_s": 2.0, "settle_s": 1.0, "tracker": "truth"}


def read(**values: Any) -> CurrentsConfiguration:
    config = benchmark("currents-v1").read({**QUICK, **values})
    assert isinstance(config, CurrentsConfiguration)
    return config


def test_without_loops_the_levels_are_the_benchmarks_own() -> None:
    config = read()

    assert config.level_values() == config.levels == (0.0, 0.1, 0.2, 0.3, 0.4)
    assert config.at(3) == config
    assert grid.level_comments(config)[3:] == [
        "level 3: Current 0.3 m/s",
        "level 4: Current 0.4 m/s",
    ]


def test_the_current_levels_are_the_outermost_loop_and_the_last_loop_varies_fastest() -> None:
    config = read(
        levels=[0, 0.2], loop1="turbidity", loop1_values=[0.5, 1], loop2="repeat", loop2_values=[2]
    )

    wanted = itertools.product((0.0, 0.2), (0.5, 1.0), (1.0, 2.0))
    points = [tuple(point.values()) for point in config.points()]
    assert points == list(wanted)
    assert tuple(config.grid_point(5)) == ("current_speed", "turbidity", "repeat")
    assert config.level_values() == (0.0,) * 4 + (0.2,) * 4
    assert config.trial_duration_s() == 16.0


def test_a_loop_over_the_current_replaces_the_levels() -> None:
    config = read(
        loop1="camera_noise", loop1_values=[2, 1], loop2="current_speed", loop2_values=[0.3, 0]
    )

    assert config.level_values() == (0.3, 0.0, 0.3, 0.0)
    assert [config.at(level).camera_noise_grey for level in range(4)] == [2, 2, 1, 1]


@pytest.mark.parametrize("name", UPDATERS)
def test_every_updater_gives_a_valid_configuration(name: str) -> None:
    config = read(levels=[0.1], loop1=name, loop1_values=[1.0 if name in LARGE else 0.1])

    alone = config.at(0).model_dump() | {"loop1": "none", "loop1_values": ()}
    assert benchmark("currents-v1").read(alone).model_dump() == alone


def test_each_level_has_the_water_of_its_grid_point() -> None:
    config = read(levels=[0.1], loop1="turbidity", loop1_values=[0.1, 2.0])
    cameras = [StationKeeping().camera(config, seed=1, trial=0, level=at) for at in (0, 1)]
    pose = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0])

    contrasts = [float(np.std(camera.grey(pose, 0))) for camera in cameras]

    assert contrasts[0] > 2.0 * contrasts[1]


def test_level_metrics_include_the_grid_point_and_a_held_level_needs_all_its_points() -> None:
    config = read(levels=[0, 0.1], loop1="repeat", loop1_values=[2])
    rows: list[Rows] = []

    result = run_trial(
        "currents-v1", config, BuiltIn("pi", config), seed=1, trial=0, on_rows=rows.append
    )

    levels = summarise("currents-v1", config, [result])["levels"]
    assert [level["grid"] for level in levels] == list(config.points())
    assert [level["speed"] for level in levels] == [0.0, 0.0, 0.1, 0.1]
    states = np.concatenate(rows)[:, INDEX["x"] : INDEX["yaw"] + 1].reshape(4, 40, 6)
    assert not np.array_equal(states[2], states[3])  # a repetition has gusts of its own
    spoiled = [*result.levels[:3], {**result.levels[3], "held": False}]
    assert StationKeeping().trial_score(config, spoiled).level_held == 0.0


@pytest.mark.parametrize(
    ("values", "setting", "message"),
    [
        ({"loop1": "turbidity"}, "loop1_values", "at least one value"),
        ({"loop2_values": [1]}, "loop2", "choose what"),
        ({"loop1": "fog"}, "loop1", "must be one of"),
        ({"loop1": "repeat", "loop1_values": [2.5]}, "loop1_values", "whole number from 1 to 12"),
        ({"loop1": "repeat", "loop1_values": [1, 2]}, "loop1_values", "one whole number"),
        ({"loop1": "current_speed", "loop1_values": [2]}, "loop1_values", "from 0 to 1 m/s"),
        ({"loop1": "camera_noise", "loop1_values": [0.1]}, "loop1_values", "from 0.8 to 64 grey"),
        ({"loop1": "altitude", "loop1_values": [5]}, "loop1_values", "target would be too small"),
        ({"loop1": "repeat", "loop1_values": [12], "loop2": "repeat"}, "loop2", "already"),
        (
            {"loop1": "repeat", "loop1_values": [12], "loop2": "turbidity", "loop2_values": [1, 2]},
            "loop1_values",
            "120 points; at most 60",
        ),
        (
            {"level_duration_s": 600, "loop1": "repeat", "loop1_values": [3]},
            "loop1_values",
            "9000 s of simulated time; at most 7200 s",
        ),
    ],
)
def test_an_invalid_grid_is_rejected_at_its_setting(
    values: dict[str, Any], setting: str, message: str
) -> None:
    with pytest.raises(ConfigurationInvalid, match=message) as error:
        read(**values)

    assert setting in error.value.errors


def test_a_loop_is_not_blamed_for_what_is_wrong_without_it() -> None:
    with pytest.raises(ConfigurationInvalid) as error:
        read(loop1="turbidity", loop1_values=[0.5, 99], score="cornres")

    errors = error.value.errors
    assert errors.keys() == {"score", "loop1_values"}
    assert errors["loop1_values"].startswith("loop1_values, 99: water_attenuation_1_m")
    with pytest.raises(ConfigurationInvalid) as error:
        read(loop1="turbidity", loop1_values=[0.5], score="cornres")
    assert error.value.errors.keys() == {"score"}


def test_grid_points_have_short_names_and_other_levels_have_none() -> None:
    config = read(levels=[0, 0.2], loop1="light", loop1_values=[1, 0.25])

    assert grid.level_names(config) == ("0 · 1", "0 · 0.25", "0.2 · 1", "0.2 · 0.25")
    assert grid.axes(config) == "Current [m/s] · Daylight relative to the standard"
    assert config.at(1).light_level == 0.25
    assert grid.level_names(read()) == ()


def test_a_ranked_run_has_no_grid() -> None:
    config = read(loop1="turbidity", loop1_values=[1.0], tracker="esm")

    ranked = benchmark("currents-v1").ranked(config)

    assert ranked.level_values() == (0.0, 0.1, 0.2, 0.3, 0.4)


loops = st.lists(
    st.tuples(
        st.sampled_from([name for name in UPDATERS if name not in LARGE]),
        st.lists(st.sampled_from([0.1, 0.05, 0.2]), min_size=1, max_size=3),
    ),
    max_size=3,
    unique_by=lambda loop: loop[0],
)


@pytest.mark.slow
@given(loops=loops)
def test_a_grid_has_the_points_of_nested_loops_in_their_order(
    loops: list[tuple[str, list[float]]],
) -> None:
    values: dict[str, Any] = {"levels": [0.1, 0.2]}
    for at, (name, steps) in enumerate(loops, start=1):
        values |= {f"loop{at}": name, f"loop{at}_values": steps}
    if "current_speed" not in dict(loops):
        loops = [("current_speed", [0.1, 0.2]), *loops]

    config = read(**values)

    assert [list(point.values()) for point in config.points()] == [
        list(point) for point in itertools.product(*(steps for _, steps in loops))
    ]
