"""Sums of arrays have the bits of `math.fsum`, whatever their numbers are."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.exact_sums import exact_mean, exact_root_mean_square, exact_sum
from seamark.sim.numerics.statistics import mean, root_mean_square

FINITE = st.floats(-1e300, 1e300)
ARRAYS = arrays(np.float64, st.integers(0, 40), elements=FINITE)


@given(values=ARRAYS, cancelling=st.booleans())
def test_a_sum_has_the_bits_of_fsum(values: Array, cancelling: bool) -> None:
    if cancelling:
        values = np.concatenate([values, -values[1:], [2.0**-1074, 1e-300]])

    assert exact_sum(values).hex() == math.fsum(values.tolist()).hex()


@pytest.mark.parametrize("tie", [2.0**-53, 3.0 * 2.0**-53, 2.0**-53 + 2.0**-1074])
def test_a_tie_is_rounded_as_by_fsum(tie: float) -> None:
    values = np.array([1.0, tie])

    assert exact_sum(values) == math.fsum([1.0, tie])


@pytest.mark.parametrize("last", [math.nan, math.inf, -math.inf])
def test_what_is_not_finite_is_as_in_fsum(last: float) -> None:
    np.testing.assert_equal(exact_sum(np.array([1.0, last])), math.fsum([1.0, last]))


@given(values=arrays(np.float64, st.integers(0, 40), elements=st.floats(-1e100, 1e100)))
def test_means_have_the_bits_of_those_of_lists(values: Array) -> None:
    listed = values.tolist()

    np.testing.assert_equal(exact_mean(values), mean(listed))
    np.testing.assert_equal(exact_root_mean_square(values), root_mean_square(listed))


def test_columns_of_a_table_are_summed_as_well() -> None:
    table = np.arange(12.0).reshape(4, 3)

    assert exact_sum(table[:, 1]) == 22.0
    assert exact_mean(table) == 5.5
