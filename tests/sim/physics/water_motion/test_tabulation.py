"""A level's table has the level's mean, and the place's, the record's and the waves' variations."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from seamark.sim.numerics.random_streams import streams
from seamark.sim.physics.current import TABLE_GRID_S, Current, Pattern, Shear
from seamark.sim.physics.water_motion.places import PLACES
from seamark.sim.physics.water_motion.record import Record
from seamark.sim.physics.water_motion.tabulation import Motion, Site, current_of, stretch_of
from seamark.sim.physics.water_motion.waves import Waves

SITE = Site(bottom_m=5.0, start_m=2.73, azimuth_rad=0.4, duration_s=60.0)
TIMES = TABLE_GRID_S * np.arange(601)


def velocities(current: Current, depth_m: float = SITE.start_m) -> np.ndarray:
    return np.array([current.velocity(float(t), depth_m) for t in TIMES])


def tide(speed: float = 0.6, heights: tuple[float, ...] = (1.0, 2.0, 4.0)) -> Record:
    """Six hours that grow to a speed, turn with height and have a slow vertical motion."""
    times = np.arange(361) * 60.0
    strength = speed * np.sin(np.pi * times / times[-1])
    rows = []
    for height in heights:
        turn = 0.1 * height
        share = height ** (1.0 / 7.0)
        rows.append(
            [strength * share * np.cos(turn), strength * share * np.sin(turn), 0.02 * strength]
        )
    return Record(60.0, np.array(heights), np.array(rows), {})


@pytest.mark.parametrize("name", PLACES)
@given(level=st.floats(0.05, 1.0), azimuth=st.floats(-3.1, 3.1))
def test_the_mean_velocity_of_a_place_is_the_level_from_its_azimuth(
    name: str, level: float, azimuth: float
) -> None:
    site = Site(bottom_m=5.0, start_m=2.5, azimuth_rad=azimuth, duration_s=60.0)
    current = current_of(level, Motion(place=PLACES[name]), site, streams(1, 0, 0))

    mean = velocities(current, 2.5).mean(axis=0)

    expected = [-level * np.cos(azimuth), -level * np.sin(azimuth), 0.0]
    assert mean == pytest.approx(expected, abs=1e-9)


def test_the_mean_at_a_start_between_two_depths_is_the_level_within_a_thousandth() -> None:
    current = current_of(0.5, Motion(place=PLACES["ria"]), SITE, streams(1, 0, 0))

    assert np.hypot(*velocities(current).mean(axis=0)[:2]) == pytest.approx(0.5, rel=1e-3)


@pytest.mark.parametrize("name", PLACES)
def test_the_current_of_a_place_is_slower_the_deeper(name: str) -> None:
    current = current_of(0.5, Motion(place=PLACES[name]), SITE, streams(1, 0, 0))

    means = [np.hypot(*velocities(current, d).mean(axis=0)[:2]) for d in (0.5, 1.5, 3.0, 4.0, 4.8)]

    assert all(a > b for a, b in pairwise(means))


def test_still_water_at_a_place_is_still_but_for_waves() -> None:
    place = PLACES["channel"]
    still = current_of(0.0, Motion(place=place), SITE, streams(1, 0, 0))
    waves = current_of(0.0, Motion(place=place, waves=Waves(0.5, 5.0)), SITE, streams(1, 0, 0))

    assert not velocities(still).any()
    assert velocities(waves).std(axis=0)[0] > 0.02


def test_a_record_is_turned_and_scaled_to_the_level() -> None:
    current = current_of(0.3, Motion(record=tide()), SITE, streams(1, 0, 0))

    mean = velocities(current).mean(axis=0)

    assert np.hypot(*mean[:2]) == pytest.approx(0.3, rel=2e-3)
    assert np.arctan2(-mean[1], -mean[0]) == pytest.approx(0.4, abs=0.02)
    assert mean[2] == pytest.approx(0.02 * 0.3, rel=0.2)


def test_a_stretch_is_chosen_whose_own_mean_is_near_the_level() -> None:
    record, chosen = tide(), set()
    for trial in range(20):
        stretch = stretch_of(0.3, record, SITE, streams(1, trial, 0).record)
        chosen.add(stretch.at_s)
        assert stretch.factor == pytest.approx(1.0, abs=0.15)
        assert stretch.speed * stretch.factor == pytest.approx(0.3)
    too_strong = stretch_of(3.0, record, SITE, streams(1, 0, 0).record)

    assert len(chosen) > 5
    assert too_strong.factor > 4.0
    assert abs(too_strong.at_s - 10_800.0) < 3600.0


def test_a_record_with_a_place_has_the_places_turbulence_around_the_records_mean() -> None:
    spreads = []
    for trial in range(12):
        plain, rough = (
            velocities(
                current_of(0.4, Motion(record=tide(), place=place), SITE, streams(1, trial, 0))
            )
            for place in (None, PLACES["ria"])
        )
        assert plain.std(axis=0)[:2].max() < 0.005
        assert rough.mean(axis=0) == pytest.approx(plain.mean(axis=0), abs=1e-9)
        spreads.append(np.hypot(*rough.std(axis=0)[:2]))

    # 0.1 along and 0.075 across; a minute shows about two thirds of that variance.
    assert np.mean(spreads) == pytest.approx(0.125 * (2.0 / 3.0) ** 0.5, rel=0.15)


def test_waves_over_a_current_of_sinusoids_leave_it_as_it_is() -> None:
    base = Current(
        0.4,
        pattern=Pattern(azimuth_rad=0.4),
        shear=Shear(exponent=0.2, bottom_m=5.0, height_m=2.27),
        rng=streams(1, 0, 0).gust,
        duration_s=60.0,
    )
    flat = current_of(0.4, Motion(base=base, waves=Waves(1e-9, 5.0)), SITE, streams(1, 0, 0))

    for depth in (0.5, 2.5, 4.5):
        assert velocities(flat, depth) == pytest.approx(velocities(base, depth), abs=2e-3)


def test_above_and_below_its_depths_the_table_is_constant_and_takes_what_is_no_number() -> None:
    current = current_of(0.4, Motion(place=PLACES["ria"]), SITE, streams(1, 0, 0))
    top, bottom = current.velocity(7.03, 0.5), current.velocity(7.03, 5.0)

    assert current.velocity(7.03, -100.0).tobytes() == top.tobytes()
    assert current.velocity(7.03, 1e300).tobytes() == bottom.tobytes()
    assert np.all(np.isnan(current.velocity(7.03, float("nan"))))  # and reads nothing it may not


def test_after_its_end_the_water_moves_on_steadily() -> None:
    current = current_of(0.4, Motion(place=PLACES["ria"]), SITE, streams(1, 0, 0))
    end = current.velocity(current.duration_s, 2.5)

    assert current.velocity(current.duration_s + 12.0, 2.5).tobytes() == end.tobytes()
    assert np.hypot(*end[:2]) < 1.0


def test_the_acceleration_and_the_shear_are_the_slopes_of_the_velocity() -> None:
    from seamark.sim.physics.current import moving_in

    motion = Motion(place=PLACES["ria"], waves=Waves(0.5, 5.0))
    water = current_of(0.4, motion, SITE, streams(1, 0, 0)).water
    t, z, h = 7.03, 2.73, 1e-5

    moving = moving_in(t, z, water)
    in_time = np.subtract(moving_in(t + h, z, water)[:3], moving_in(t - h, z, water)[:3]) / (2 * h)
    in_depth = np.subtract(moving_in(t, z + h, water)[:3], moving_in(t, z - h, water)[:3]) / (2 * h)

    assert moving[3:6] == pytest.approx(in_time, abs=1e-8)
    assert moving[6:9] == pytest.approx(in_depth, abs=1e-8)
    assert np.all(np.abs(moving[:9]) > 0.0)
