"""The current: the published pattern, a gust with the right statistics, no step in it anywhere."""

import numpy as np
import pytest

from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.random_streams import streams
from seamark.sim.physics.current import (
    GUST_GRID_S,
    Change,
    Current,
    Pattern,
    Segment,
    flow,
    segment_at,
)

STEADY = Pattern(azimuth_swing_rad=0.0, speed_swing=0.0)


def speeds(current: Current, times: Array) -> Array:
    return np.array([np.hypot(*current.velocity(t)[:2]) for t in times])


def test_current_from_ahead_flows_south_and_from_starboard_west() -> None:
    bow = Current(0.4, pattern=STEADY).velocity(3.0)
    beam = Current(
        0.4, pattern=Pattern(azimuth_rad=np.pi / 2, azimuth_swing_rad=0.0, speed_swing=0.0)
    ).velocity(3.0)

    assert bow == pytest.approx([-0.4, 0.0, 0.0], abs=1e-15)
    assert beam == pytest.approx([0.0, -0.4, 0.0], abs=1e-15)


def test_the_pattern_is_the_published_one() -> None:
    current = Current(0.3)

    for t in (0.0, 1.0, 7.5, 22.5, 61.3):
        speed = 0.3 + 0.005 * np.sin(2 * np.pi * t / 4)
        angle = 0.7 * np.sin(2 * np.pi * t / 30)
        expected = [-speed * np.cos(angle), -speed * np.sin(angle), 0.0]
        assert current.velocity(t) == pytest.approx(expected, abs=1e-14)


def test_level_zero_is_still_water() -> None:
    current = Current(0.0, rng=streams(1, 0, 0).gust)

    assert [current.velocity(t).any() for t in (0.0, 1.0, 50.0)] == [False, False, False]


@pytest.mark.parametrize("law", ["relative", "force"])
def test_reported_acceleration_is_the_slope_of_the_velocity(law: str) -> None:
    pattern = Pattern(law="relative" if law == "relative" else "force")
    water = Current(0.4, pattern=pattern, rng=streams(1, 0, 0).gust).water
    t, h = 17.321, 1e-5
    segment = segment_at(t, 0.0, water.law, (0.0, 1.0), water.drift)

    before, after = flow(t - h, water, segment), flow(t + h, water, segment)
    slope = [(b - a) / (2 * h) for a, b in zip(before[:2], after[:2], strict=True)]

    assert flow(t, water, segment)[2:4] == pytest.approx(slope, abs=1e-9)


def test_the_force_law_is_the_published_one() -> None:
    pattern = Pattern(law="force", speed_swing=0.0)
    water = Current(0.4, pattern=pattern).water

    def at(t: float) -> Segment:
        return segment_at(t, 0.0, water.law, (0.0, 1.0), water.drift)

    *still, surge, sway = flow(7.5, water, at(7.5))
    *_still, surge_later, _sway = flow(22.5, water, at(22.5))

    assert still == [0.0, 0.0, 0.0, 0.0]
    assert sway == pytest.approx(410.0 * 0.134 * 0.4**2)
    assert surge == pytest.approx(410.0 * 0.134 * (0.4 * np.sin(0.7)) ** 2)
    assert surge_later == pytest.approx(surge)


def test_the_gust_has_its_standard_deviation_and_correlation_time() -> None:
    water = Current(1.0, rng=streams(3, 0, 0).gust, duration_s=20_000.0).water
    gust, lag = water.drift[0], round(10.0 / GUST_GRID_S)

    correlation = np.mean(gust[lag:] * gust[:-lag]) / np.var(gust)

    assert gust.std() == pytest.approx(0.05, rel=0.1)
    assert abs(gust.mean()) < 0.008
    assert correlation == pytest.approx(np.exp(-1.0), abs=0.08)


def test_the_gust_starts_in_its_stationary_distribution() -> None:
    starts = [Current(1.0, rng=streams(seed, 0, 0).gust).water.drift[0][0] for seed in range(400)]

    assert np.std(starts) == pytest.approx(0.05, rel=0.12)


def test_a_longer_level_begins_with_the_same_gust() -> None:
    short = Current(0.2, rng=streams(3, 0, 0).gust, duration_s=10.0).water.drift[0]
    long = Current(0.2, rng=streams(3, 0, 0).gust, duration_s=120.0).water.drift[0]

    assert np.array_equal(short, long[: short.size])


@pytest.mark.slow
def test_the_gust_does_not_jump() -> None:
    current = Current(0.4, pattern=STEADY, rng=streams(3, 0, 0).gust)

    changes = np.diff(speeds(current, np.arange(0.0, 120.0, 0.001)))

    assert np.abs(changes).max() < 1e-3


def test_after_its_end_the_last_segment_of_the_gust_is_used() -> None:
    current = Current(0.4, pattern=STEADY, rng=streams(3, 0, 0).gust, duration_s=10.0)

    assert speeds(current, np.array([10.0]))[0] == pytest.approx(0.4, abs=0.15)


@pytest.mark.parametrize(
    "wrong", [{"azimuth_period_s": 0.0}, {"gust_share": -0.1}, {"gust_time_s": float("nan")}]
)
def test_impossible_patterns_are_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(ValueError, match=next(iter(wrong))):
        Pattern(**wrong)  # type: ignore[arg-type]


def test_a_negative_level_is_refused() -> None:
    with pytest.raises(ValueError, match="not be negative"):
        Current(-0.1)


def test_phases_shift_both_sinusoids() -> None:
    shifted = Current(0.3, pattern=Pattern(azimuth_phase_rad=np.pi / 2, speed_phase_rad=-np.pi / 2))

    for t in (0.0, 7.5, 22.5):
        speed = 0.3 - 0.005 * np.cos(2 * np.pi * t / 4)
        angle = 0.7 * np.cos(2 * np.pi * t / 30)
        expected = [-speed * np.cos(angle), -speed * np.sin(angle), 0.0]
        assert shifted.velocity(t) == pytest.approx(expected, abs=1e-14)


def test_a_change_is_linear_over_its_time_and_lasts() -> None:
    changes = (
        Change(at_s=10.0, turn_rad=0.5, speed_share=-0.25),
        Change(at_s=20.0, turn_rad=-0.2, speed_share=0.5),
    )
    pattern = Pattern(azimuth_swing_rad=0.0, speed_swing=0.0, changes=changes)
    current = Current(0.4, pattern=pattern, duration_s=60.0)

    def direction(t: float) -> float:
        x, y, _z = current.velocity(t)
        return float(np.arctan2(-y, -x))

    times = np.array([0.0, 9.9, 11.0, 12.1, 19.9, 21.0, 22.1, 59.9])
    assert speeds(current, times) == pytest.approx([0.4, 0.4, 0.35, 0.3, 0.3, 0.4, 0.5, 0.5])
    assert [direction(t) for t in times] == pytest.approx([0, 0, 0.25, 0.5, 0.5, 0.4, 0.3, 0.3])


def test_the_acceleration_is_the_slope_of_the_velocity_during_a_change() -> None:
    changes = (Change(at_s=10.0, turn_rad=0.5, speed_share=-0.25),)
    pattern = Pattern(azimuth_phase_rad=0.3, speed_phase_rad=1.0, changes=changes)
    water = Current(0.4, pattern=pattern, rng=streams(1, 0, 0).gust, duration_s=20.0).water
    t, h = 11.02, 1e-5
    segment = segment_at(t, 0.0, water.law, (0.0, 1.0), water.drift)

    before, after = flow(t - h, water, segment), flow(t + h, water, segment)
    slope = [(b - a) / (2 * h) for a, b in zip(before[:2], after[:2], strict=True)]

    assert flow(t, water, segment)[2:4] == pytest.approx(slope, abs=1e-9)


def test_changes_leave_the_gust_as_it_was() -> None:
    changes = (Change(at_s=10.0, turn_rad=0.5, speed_share=0.25),)
    plain = Current(0.4, rng=streams(1, 0, 0).gust, duration_s=20.0).water
    changed = Current(
        0.4, pattern=Pattern(changes=changes), rng=streams(1, 0, 0).gust, duration_s=20.0
    ).water

    before = round(10.0 / GUST_GRID_S)
    assert np.array_equal(plain.drift[:, :before], changed.drift[:, :before])
    assert changed.drift[0, -1] - plain.drift[0, -1] == pytest.approx(0.1)
