"""Student's t distribution against SciPy."""

import pytest
import scipy  # its parts are loaded when they are used
from hypothesis import given
from hypothesis import strategies as st

from seamark.sim.numerics.student_t import quantile, tail


@pytest.mark.slow
@given(t=st.floats(0.0, 200.0), degrees=st.floats(0.6, 1e5))
def test_the_tail_is_that_of_scipy(t: float, degrees: float) -> None:
    assert tail(t, degrees) == pytest.approx(scipy.stats.t.sf(t, degrees), rel=1e-9, abs=1e-290)


@pytest.mark.parametrize("degrees", [1, 1.5, 2, 4.7, 9, 19, 49, 99.5, 1e4])
@pytest.mark.parametrize("probability", [0.3, 0.025, 0.0005, 2.5e-8])
def test_the_quantile_is_that_of_scipy(probability: float, degrees: float) -> None:
    expected = scipy.stats.t.isf(probability, degrees)

    assert quantile(probability, degrees) == pytest.approx(expected, rel=1e-10)


def test_the_bits_of_a_quantile_never_change() -> None:
    assert quantile(0.025, 9).hex() == "0x1.218e5dac50b11p+1"
