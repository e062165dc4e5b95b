"""How the values of levels and trials become one."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from seamark.sim.metrics.metric import (
    MAX,
    MEAN,
    RMS,
    SUM,
    Aggregation,
    mean_over_trials,
    weighted_by,
)


@pytest.mark.parametrize(
    ("aggregation", "value"), [(MEAN, 3.5), (RMS, math.sqrt(12.5)), (SUM, 7.0), (MAX, 4.0)]
)
def test_each_aggregation_is_what_its_name_says(aggregation: Aggregation, value: float) -> None:
    assert aggregation.of("a", [{"a": 3.0}, {"a": 4.0}]) == pytest.approx(value)


@pytest.mark.parametrize("aggregation", [MEAN, RMS, SUM, MAX])
def test_a_level_without_a_value_leaves_the_run_without_one(aggregation: Aggregation) -> None:
    assert aggregation.of("a", [{"a": 3.0}, {"a": None}]) is None


@pytest.mark.parametrize("values", [(1.0, math.nan), (math.nan, 1.0)])
def test_the_maximum_of_an_undefined_value_is_undefined(values: tuple[float, float]) -> None:
    maximum = MAX.of("a", [{"a": value} for value in values])

    assert maximum is not None
    assert math.isnan(maximum)


def test_a_weighted_mean_ignores_levels_of_weight_0() -> None:
    levels = [{"a": 1.0, "n": 3.0}, {"a": 5.0, "n": 1.0}, {"a": math.nan, "n": 0.0}]

    assert weighted_by("n").of("a", levels) == 2.0


def test_a_weighted_mean_without_any_weight_is_undefined() -> None:
    mean = weighted_by("n").of("a", [{"a": 1.0, "n": 0.0}])

    assert mean is not None
    assert math.isnan(mean)


@given(st.lists(st.tuples(st.floats(-9.0, 9.0), st.floats(0.1, 9.0)), min_size=1))
def test_a_weighted_mean_lies_between_the_values(pairs: list[tuple[float, float]]) -> None:
    mean = weighted_by("n").of("a", [{"a": value, "n": weight} for value, weight in pairs])

    values = [value for value, _ in pairs]
    assert mean is not None
    assert min(values) - 1e-9 <= mean <= max(values) + 1e-9


def test_the_mean_over_trials_includes_nested_metrics_and_keeps_texts() -> None:
    trials = [
        {"level": 1, "held": True, "a": 1.0, "measures": {"b": 2.0, "c": None}, "at": "x"},
        {"level": 1, "held": False, "a": 2.0, "measures": {"b": 4.0, "c": 1.0}, "at": "x"},
    ]

    merged = mean_over_trials(trials)

    inner = {"b": 3.0, "c": None}
    assert merged == {"level": 1, "held": False, "a": 1.5, "measures": inner, "at": "x"}
