"""Means, percentiles, intervals and areas."""

import math

import numpy as np
import pytest
import scipy  # its parts are loaded when they are used
from hypothesis import assume, given
from hypothesis import strategies as st

from seamark.sim.numerics.statistics import (
    area,
    difference_interval,
    mean,
    mean_interval,
    paired_interval,
    percentile,
    root_mean_square,
)

scores = st.lists(st.floats(0.0, 100.0), min_size=2, max_size=12)


def test_statistics_of_no_values_are_nan() -> None:
    assert all(math.isnan(f([])) for f in (mean, root_mean_square))
    assert math.isnan(percentile([], 0.5))


@given(values=scores, share=st.floats(0.0, 1.0))
def test_percentiles_are_those_of_numpy(values: list[float], share: float) -> None:
    assert percentile(values, share) == pytest.approx(np.quantile(values, share), abs=1e-9)


@pytest.mark.slow
@given(values=scores)
def test_the_interval_is_that_of_scipy(values: list[float]) -> None:
    assume(len(set(values)) > 1)
    error = scipy.stats.sem(values)
    assume(error > 1e-9)

    expected = scipy.stats.t.interval(0.95, len(values) - 1, np.mean(values), error)
    assert mean_interval(values) == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_the_interval_does_not_depend_on_the_order_of_the_trials() -> None:
    values = [70.0, 80.0, 75.0, 90.0, 60.0]

    assert mean_interval(values) == mean_interval(values[::-1])


def test_the_interval_of_equal_scores_is_a_point() -> None:
    assert mean_interval([80.0, 80.0, 80.0]) == (80.0, 80.0)


def test_one_trial_has_no_interval() -> None:
    assert mean_interval([80.0]) is None


def test_trials_of_two_vehicles_are_averaged_before_the_interval_is_computed() -> None:
    values = [10.0, 50.0, 12.0, 52.0, 14.0, 54.0]  # what differs between the vehicles is no chance

    assert mean_interval(values, block=2) == mean_interval([30.0, 32.0, 34.0])


def test_an_incomplete_block_has_no_interval() -> None:
    assert mean_interval([1.0, 2.0, 3.0, 4.0, 5.0], block=2) is None
    assert mean_interval([1.0, 2.0], block=2) is None


@pytest.mark.slow
@given(first=scores, second=scores)
def test_the_interval_of_a_difference_is_that_of_scipy(
    first: list[float], second: list[float]
) -> None:
    assume(min(scipy.stats.sem(first), scipy.stats.sem(second)) > 1e-6)

    expected = scipy.stats.ttest_ind(first, second, equal_var=False).confidence_interval(0.95)
    found = difference_interval(first, second)
    assert found == pytest.approx((expected.low, expected.high), rel=1e-6, abs=1e-9)


def test_the_difference_of_two_runs_without_spread_is_a_point() -> None:
    assert difference_interval([2.0, 2.0], [1.0, 1.0, 1.0]) == (1.0, 1.0)


def test_a_difference_needs_two_blocks_of_both() -> None:
    assert difference_interval([1.0, 2.0], [3.0]) is None
    assert difference_interval([1.0, 2.0], [3.0, 4.0], block=2) is None


def test_what_the_trials_have_in_common_cancels_out_in_a_paired_interval() -> None:
    luck = [0.0, 9.0, 4.0, 7.0, 2.0]
    first = [50.0 + each for each in luck]
    second = [49.0 + each for each in luck]

    assert paired_interval(first, second) == (1.0, 1.0)
    with pytest.raises(ValueError, match="zip"):
        paired_interval(first, second[1:])


def test_the_area_of_a_step_is_where_it_falls() -> None:
    levels = [0.0, 0.2, 0.4, 0.6, 0.8]

    assert area(levels, [1.0, 1.0, 1.0, 0.0, 0.0]) == pytest.approx(0.5)
    assert area(levels, [1.0] * 5) == pytest.approx(0.8)
    assert area(levels, [0.0] * 5) == 0.0


def test_the_area_does_not_depend_on_the_order_of_the_levels() -> None:
    assert area([0.4, 0.0, 0.2], [0.1, 1.0, 0.7]) == area([0.0, 0.2, 0.4], [1.0, 0.7, 0.1])


qualities = st.lists(st.floats(0.0, 1.0), min_size=6, max_size=6)


@given(first=qualities, second=qualities)
def test_the_area_is_linear_in_the_trials(first: list[float], second: list[float]) -> None:
    levels = [0.0, 0.1, 0.2, 0.4, 0.8, 1.2]
    both = [mean(pair) for pair in zip(first, second, strict=True)]

    expected = mean([area(levels, first), area(levels, second)])
    assert area(levels, both) == pytest.approx(expected, abs=1e-12)
