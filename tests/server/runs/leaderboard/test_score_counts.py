"""Classes of scores: every score has one, in order, and errors are never understated."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from seamark.server.runs.leaderboard.score_counts import (
    ERRORS_PER_OCTAVE,
    UNKNOWN_ERROR,
    error_class,
    key_of,
    lower_ends,
    score_class,
)
from seamark.sim.numerics.ranking import Estimate

scores = st.floats(-1e300, 1e300)


@given(score=scores | st.floats(0.0, 100.0))
def test_a_score_lies_in_its_class(score: float) -> None:
    number = score_class(score)
    low, high = lower_ends(np.array([number, number + 1]))

    assert low <= score < high


@given(one=scores | st.floats(0.0, 8.0), other=scores | st.floats(0.0, 8.0))
def test_a_higher_score_never_has_a_lower_class(one: float, other: float) -> None:
    low, high = sorted((one, other))

    assert score_class(low) <= score_class(high)


@given(score=st.floats(0.001, 1000.0))
def test_a_class_is_narrow(score: float) -> None:
    number = score_class(score)
    low, high = lower_ends(np.array([number, number + 1]))

    assert high - low <= score / 256


@given(error=st.floats(0.0, 1e6))
def test_a_class_never_understates_an_error_nor_overstates_it_by_half(error: float) -> None:
    largest = 2.0 ** (error_class(error) / ERRORS_PER_OCTAVE)

    assert error <= largest * (1.0 + 1e-12)
    assert largest <= max(1.5 * error, 1e-12)


def test_an_unknown_error_has_its_own_class() -> None:
    unknown = Estimate(score=50.0, standard_error=None, degrees=0)

    assert key_of(unknown) == (score_class(50.0), UNKNOWN_ERROR, 0)
