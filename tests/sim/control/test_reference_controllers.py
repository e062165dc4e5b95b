"""The marks on the leaderboard: nothing, blind and the oracle."""

from typing import Any

import numpy as np
import pytest

from seamark.sim.control.observation import STARTS, empty
from seamark.sim.engine.program import BuiltIn
from seamark.sim.engine.trial import TrialResult, run_trial
from seamark.sim.recording.telemetry import INDEX, Rows
from seamark.sim.registry import CONTROLLERS, benchmark
from seamark.sim.settings.trial_spreads import GROUP

STRONG = {
    "tracker": "truth",
    "levels": [0.4],
    "level_duration_s": 20.0,
    "settle_s": 10.0,
    "dvl_bias_m_s": 0.02,
}


NOTHING_DRAWN = {
    name: 0
    for name, entry in benchmark("currents-v2").schema()["properties"].items()
    if entry["x-group"] == GROUP and entry["type"] != "boolean"
}


def trial(name: str, version: str, **settings: Any) -> tuple[TrialResult, Rows]:
    entry = benchmark(version)
    config = entry.read(STRONG | settings)
    rows: list[Rows] = []
    program = entry.load().built_in(name, config)
    result = run_trial(
        version,
        config,
        program,
        seed=5,
        trial=0,
        on_rows=lambda some: rows.append(some.copy()),
    )
    return result, np.concatenate(rows)


def driven(name: str, **settings: Any) -> Rows:
    return trial(name, "currents-v1", **settings)[1]


def test_nothing_commands_nothing_and_drifts_away() -> None:
    rows = driven("nothing")

    assert not rows[:, INDEX["ref_u"] : INDEX["ref_r"] + 1].any()
    assert rows[-1, INDEX["distance"]] > 0.5


def test_blind_never_uses_what_the_camera_sees() -> None:
    program = BuiltIn("blind", benchmark("currents-v1").read({}))
    program.reset({"index": 0})
    values = empty(5)
    values[STARTS["dt"]], values[STARTS["velocity"]] = 0.05, 0.1

    unseen = program.step(values)
    program.reset({"index": 0})
    for name in ("error", "error_px", "target_visible"):
        values[STARTS[name]] = 1.0

    assert program.step(values) == unseen
    assert unseen[0] < 0.0


def test_blind_drifts_with_the_bias_of_the_dvl() -> None:
    rows = driven("blind", levels=[0.0])

    assert rows[-1, INDEX["distance"]] == pytest.approx(20.0 * np.hypot(0.02, 0.02), rel=0.2)


@pytest.mark.slow
@pytest.mark.parametrize("vehicle", ["girona500", "bluerov2-heavy"])
def test_the_oracle_holds_station_within_a_centimetre(vehicle: str) -> None:
    rows = driven("oracle", vehicle=vehicle)

    assert rows[:, INDEX["distance"]].max() < 0.01
    assert np.abs(rows[:, INDEX["yaw"]]).max() < 0.01


def test_the_oracle_is_limited_by_the_thrusters() -> None:
    rows = driven("oracle", current_azimuth_rad=1.57, levels=[0.7])

    assert rows[-1, INDEX["distance"]] > 1.0
    assert np.abs(rows[:, INDEX["thrust_0"] : INDEX["thrust_0"] + 5]).max() <= 104.7


def test_the_oracle_knows_how_weak_a_faulty_thruster_is() -> None:
    rows = driven("oracle", fault_thruster=0, fault_efficiency=0.7, levels=[0.3])

    assert rows[:, INDEX["distance"]].max() < 0.01


@pytest.mark.parametrize("azimuth", [1.3, -1.3])
def test_the_oracle_turns_about_the_tool_towards_a_current_from_the_side(azimuth: float) -> None:
    abeam = {"current_azimuth_rad": azimuth, "vehicle": "girona500", "levels": [0.5]}

    result, rows = trial("oracle", "currents-v2", **NOTHING_DRAWN | abeam)

    assert result.levels[0]["tool_rmse_m"] < 0.05
    assert rows[-1, INDEX["yaw"]] * azimuth > 0.5
    assert rows[-1, INDEX["distance"]] > 0.3  # the camera moved, the tool did not


@pytest.mark.parametrize("name", CONTROLLERS)
def test_no_controller_that_users_may_choose_sees_the_truth(name: str) -> None:
    assert BuiltIn(name, benchmark("currents-v1").read({})).oracle is None
