"""The conditions of a trial: within their spreads, from streams that nothing else touches."""

import json
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from seamark.sim.benchmarks.currents_v2.experiment import EXPERIMENT
from seamark.sim.benchmarks.currents_v2.settings import CurrentsConfiguration
from seamark.sim.engine.trial_conditions import TrialConditions
from seamark.sim.registry import benchmark
from seamark.sim.settings.setting import group_of
from seamark.sim.settings.trial_spreads import GROUP

OFF: dict[str, Any] = {
    name: False if name == "shuffle_levels" else 0
    for name, field in CurrentsConfiguration.model_fields.items()
    if group_of(field) == GROUP and name != "weak_thruster_loss"
}


def drawn(seed: int, trial: int = 0, **settings: Any) -> TrialConditions:
    config = CurrentsConfiguration.read(settings)
    return EXPERIMENT.drawn(config, seed=seed, trial=trial)


def flat(conditions: TrialConditions) -> dict[str, Any]:
    values = conditions.as_dict()
    return values.pop("current") | {"factors": values.pop("vehicle")} | values


@given(seed=st.integers(0, 2**63 - 1), trial=st.integers(0, 100))
def test_everything_drawn_is_within_its_spread(seed: int, trial: int) -> None:
    config = CurrentsConfiguration.read({})
    drawn = EXPERIMENT.drawn(config, seed=seed, trial=trial)
    current = drawn.current

    assert abs(current.azimuth_rad) <= 3.14
    assert abs(current.swing_phase_rad) <= 3.14
    assert 0.5 <= current.swing_factor <= 1.5
    assert 0.5 <= current.gust_factor <= 1.5
    assert len(current.changes) in (1, 2)
    assert all(abs(change.turn_rad) <= 0.8 for change in current.changes)
    assert all(12.0 <= change.at_s <= 51.0 for change in current.changes)
    assert max(map(abs, drawn.start_offset_m)) <= 0.4
    assert all(0.005 <= abs(bias) <= 0.01 for bias in drawn.dvl_bias_m_s)
    assert abs(drawn.ahrs_bias_rad[2]) <= 0.02
    assert drawn.camera_delay_steps in range(4)
    assert drawn.command_delay_steps in range(3)
    assert all(0.8 <= factor <= 1.2 for factor in drawn.vehicle.drag)
    assert all(0.45 <= gain <= 1.1 for gain in drawn.thruster_gains or ())
    assert sorted(drawn.order) == list(range(len(config.levels)))


def test_a_quarter_of_the_trials_has_one_weak_thruster() -> None:
    gains = np.array([drawn(7, 2 * trial, thrust_spread=0).thruster_gains for trial in range(400)])

    weak = (gains < 1.0).sum(axis=1)

    assert set(weak) == {0, 1}
    assert weak.mean() == pytest.approx(0.25, abs=0.07)
    assert np.all((gains[gains < 1.0] >= 0.5) & (gains[gains < 1.0] <= 0.75))


@pytest.mark.slow
def test_all_latencies_are_equally_likely() -> None:
    delays = [drawn(7, trial) for trial in range(600)]

    camera = np.bincount([one.camera_delay_steps for one in delays]) / 600
    command = np.bincount([one.command_delay_steps for one in delays]) / 600

    assert camera == pytest.approx([0.25] * 4, abs=0.06)
    assert command == pytest.approx([1 / 3] * 3, abs=0.06)


def test_with_all_spreads_off_every_trial_is_nominal() -> None:
    nominal = drawn(3, **OFF)
    changes = tuple(
        replace(change, turn_rad=0.0, speed_share=0.0) for change in nominal.current.changes
    )

    current = replace(TrialConditions().current, changes=changes)
    assert nominal == TrialConditions(
        current=current, thruster_gains=(1.0,) * 5, order=tuple(range(8))
    )


@pytest.mark.parametrize("off", OFF)
def test_switching_one_spread_off_changes_no_other_draw(off: str) -> None:
    touched: Mapping[str, set[str]] = {
        "azimuth_spread_rad": {"azimuth_rad"},
        "phase_spread_rad": {"swing_phase_rad", "wave_phase_rad"},
        "swing_spread": {"swing_factor", "swing_period_factor", "wave_period_factor"},
        "gust_spread": {"gust_factor", "gust_time_factor"},
        "change_turn_rad": {"changes"},
        "change_speed_share": {"changes"},
        "start_offset_m": {"start_offset_m"},
        "start_heading_rad": {"start_heading_rad"},
        "dvl_bias_spread_m_s": {"dvl_bias_m_s"},
        "ahrs_tilt_bias_rad": {"ahrs_bias_rad"},
        "ahrs_yaw_bias_rad": {"ahrs_bias_rad"},
        "camera_delay_steps": {"camera_delay_steps"},
        "command_delay_steps": {"command_delay_steps"},
        "mass_spread": {"factors"},
        "added_mass_spread": {"factors"},
        "drag_spread": {"factors"},
        "thrust_spread": {"thruster_gains"},
        "weak_thruster_probability": {"thruster_gains"},
        "shuffle_levels": {"order"},
    }
    seed = 16  # with latencies, a weak thruster and levels out of order

    whole, without = flat(drawn(seed)), flat(drawn(seed, **{off: OFF[off]}))

    assert {name for name in whole if whole[name] != without[name]} == touched[off]


def test_trials_and_seeds_differ_in_everything_that_is_continuous() -> None:
    one, other, third = flat(drawn(5, 0)), flat(drawn(5, 2)), flat(drawn(6, 0))
    discrete = {"camera_delay_steps", "command_delay_steps"}

    for name in set(one) - discrete:
        assert one[name] != other[name] != third[name] != one[name]


def test_conditions_are_plain_json_values() -> None:
    conditions = drawn(5).as_dict()

    assert json.loads(json.dumps(conditions))["order"] == list(drawn(5).order)


def test_the_start_keeps_the_target_in_view_from_every_corner_of_its_spread() -> None:
    entry = benchmark("currents-v2")
    config = entry.read({})

    for trial in range(0, 60, 2):
        world = EXPERIMENT.world(
            CurrentsConfiguration.read({"vehicle": "girona500"}), seed=11, trial=trial, level=0
        )
        corners = world.camera.corners(world.start)
        world.close()

        assert np.all((corners >= 0) & (corners < [config.camera_width_px, 480]))
