"""What a program is told of a dock, and what is recorded of it."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from seamark.sim.benchmarks.dock_v1.experiment import EXPERIMENT
from seamark.sim.benchmarks.dock_v1.scene import seat
from seamark.sim.benchmarks.dock_v1.settings import DockConfiguration
from seamark.sim.control.observation import Observation
from seamark.sim.engine.program import Command
from seamark.sim.recording.telemetry import DOCK_INDEX, INDEX, Rows
from seamark.sim.vehicles import load

VEHICLE = "bluerov2-heavy-v2"
EXACT = {
    "fix_period_s": 0.5,
    "fix_delay_s": 0.0,
    "fix_dropout": 0.0,
    "fix_range_sigma_m": 0.0,
    "fix_angle_sigma_rad": 0.0,
    "light_sigma_px": 0.0,
    "turbidity_1_m": 0.0,
}
# Starts right above the dock, with the marker and its lamps in view.
ABOVE = {"approach_least_m": 0.0, "approach_most_m": 0.0, "approach_rise_m": 0.0}
FAR = {"approach_least_m": 9.0, "approach_most_m": 9.0}  # out of view


class Watcher:
    """Keeps what it is told, and holds still."""

    def __init__(self) -> None:
        self.told: list[Observation] = []

    def reset(self, level: Mapping[str, float | int]) -> None:
        pass

    def step(self, values: NDArray[np.float64]) -> Command:
        self.told.append(Observation(values, dock=True))
        return 0.0, 0.0, 0.0, 0.0


def watched(seconds: float, **settings: Any) -> tuple[list[Observation], Rows]:
    config = DockConfiguration.read(
        {"levels": [0.0], "level_duration_s": seconds, "vehicle": VEHICLE} | settings
    )
    watcher, rows = Watcher(), []
    EXPERIMENT.level(config, watcher, seed=8, trial=0, level=0).run(rows.append)
    return watcher.told, np.concatenate(rows)


def column(rows: Rows, name: str) -> NDArray[np.float64]:
    values: NDArray[np.float64] = rows[:, (INDEX | DOCK_INDEX)[name]]
    return values


def test_an_exact_answer_says_where_the_dock_is_from_where_the_vehicle_was() -> None:
    told, rows = watched(4.0, **EXACT)

    where = np.stack([column(rows, name) for name in "xyz"], axis=1)
    for step, one in enumerate(told[1:], start=1):
        asked = step - round(one.dock_age / one.dt)
        assert np.allclose(one.dock, seat(load(VEHICLE)) - where[asked], atol=1e-9)
        assert 0.0 <= one.dock_age <= 0.55
        assert one.dock_sigma == 0.0
    answers = np.stack([column(rows, f"dock_fix_{axis}") for axis in "xyz"], axis=1)
    assert np.allclose(answers[1:], seat(load(VEHICLE)), atol=1e-9)


def test_before_the_first_answer_its_age_is_negative() -> None:
    told, rows = watched(2.0, **(EXACT | {"fix_dropout": 1.0}))

    assert {one.dock_age for one in told} == {-1.0}
    assert np.isnan(column(rows, "dock_fix_age")).all()


def test_near_the_dock_there_are_no_answers() -> None:
    told, _rows = watched(2.0, **(EXACT | ABOVE | {"fix_least_m": 5.0}))
    far, _rows = watched(2.0, **(EXACT | ABOVE | {"fix_least_m": 0.5}))

    assert {one.dock_age for one in told} == {-1.0}
    assert far[-1].dock_age >= 0.0


def test_the_error_of_an_answer_grows_with_the_distance() -> None:
    near, far = (
        watched(3.0, fix_dropout=0.0, fix_least_m=0.0, approach_least_m=away, approach_most_m=away)
        for away in (3.0, 12.0)
    )

    assert far[0][-1].dock_sigma > 2.0 * near[0][-1].dock_sigma


def test_lamps_are_where_the_true_marker_is_in_the_image() -> None:
    told, rows = watched(2.0, **(EXACT | ABOVE | {"camera_delay_steps": 0}))

    target = np.stack([column(rows, "target_x"), column(rows, "target_y")], axis=1)
    assert np.isfinite(target).all()
    for one, here in zip(told, target, strict=True):
        assert one.light_visible == 1.0
        assert np.allclose(one.light, here - np.array([159.5, 119.5]))


@pytest.mark.parametrize(
    ("settings", "seen"),
    [(ABOVE, True), (ABOVE | {"light_depths": 0.1}, False), (FAR, False)],
)
def test_lamps_are_seen_in_view_and_within_their_optical_depth(
    settings: dict[str, object], seen: bool
) -> None:
    told, rows = watched(2.0, **(EXACT | settings))

    assert {one.light_visible for one in told[5:]} == {float(seen)}
    assert bool(np.isfinite(column(rows, "light_x")).all()) == seen


def test_the_heading_of_the_dock_is_told_and_the_columns_say_how_far_off_the_vehicle_is() -> None:
    told, rows = watched(2.0, **EXACT)
    heading = told[0].dock_heading

    off = np.stack([column(rows, name) for name in "xyz"], axis=1) - seat(load(VEHICLE))
    ahead = np.cos(heading) * off[:, 0] + np.sin(heading) * off[:, 1]
    assert np.allclose(column(rows, "dock_ahead"), ahead)
    assert np.allclose(column(rows, "dock_below"), off[:, 2])
    turn = column(rows, "yaw") - heading
    assert np.allclose(np.cos(column(rows, "dock_turn")), np.cos(turn))
    assert np.abs(column(rows, "dock_turn")).max() <= np.pi
    # The mouth is 0.65 m above the rails, on which the keel lies when it is docked.
    assert np.allclose(column(rows, "dock_depth"), off[:, 2] + 0.65)


def test_the_detector_finds_the_marker_below_and_the_tracker_follows_it() -> None:
    told, rows = watched(3.0, **(EXACT | ABOVE))

    assert column(rows, "searching")[-1] == 0.0
    assert column(rows, "looked").sum() == pytest.approx(3.0 / 0.5, abs=1)
    assert told[-1].target_visible
    assert column(rows, "tracker_error")[-1] < 6.0
    assert np.linalg.norm(told[-1].error[:2]) < 0.1
