"""Means, percentiles and the bootstrap interval."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from seamark.sim.numerics.statistics import bootstrap_interval, mean, percentile, root_mean_square

scores = st.lists(st.floats(0.0, 100.0), min_size=2, max_size=12)


def test_statistics_of_no_values_are_nan() -> None:
    assert all(math.isnan(f([])) for f in (mean, root_mean_square))
    assert math.isnan(percentile([], 0.5))


@given(values=scores, share=st.floats(0.0, 1.0))
def test_percentiles_are_those_of_numpy(values: list[float], share: float) -> None:
    assert percentile(values, share) == pytest.approx(np.quantile(values, share), abs=1e-9)


@given(values=scores)
def test_the_interval_contains_the_mean_and_lies_within_the_values(values: list[float]) -> None:
    interval = bootstrap_interval(values)

    assert interval is not None
    low, high = interval
    assert min(values) - 1e-9 <= low <= mean(values) + 1e-9
    assert mean(values) - 1e-9 <= high <= max(values) + 1e-9


def test_the_interval_does_not_depend_on_the_order_of_the_trials() -> None:
    values = [70.0, 80.0, 75.0, 90.0, 60.0]

    assert bootstrap_interval(values) == bootstrap_interval(values[::-1])


def test_the_interval_of_given_scores_never_changes() -> None:
    assert bootstrap_interval([70.0, 80.0, 75.0, 90.0, 60.0]) == (66.0, 84.0)


def test_one_trial_has_no_interval() -> None:
    assert bootstrap_interval([80.0]) is None


def test_the_interval_covers_the_true_mean_at_about_its_confidence() -> None:
    generator = np.random.default_rng(3)
    hits = 0
    for _ in range(100):
        interval = bootstrap_interval(generator.normal(50.0, 5.0, 10).tolist())
        assert interval is not None
        hits += interval[0] <= 50.0 <= interval[1]

    assert 80 <= hits <= 100
