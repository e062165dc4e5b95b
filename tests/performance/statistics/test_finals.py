"""A final's ranges hold whenever it ends, and its common trials separate what others do not."""

import numpy as np
import pytest

from performance.statistics.finals import BLOCKS, FIELDS, Field, held, measured, normal, outcome

SYNTHETIC = FIELDS[:4]


@pytest.mark.slow
@pytest.mark.parametrize("field", SYNTHETIC, ids=lambda field: field.name)
def test_at_most_five_of_a_hundred_ranges_are_false_though_the_final_ends_when_it_likes(
    field: Field,
) -> None:
    came = outcome(field, finals=150)

    assert came.false_ranges <= 5.0


@pytest.mark.slow
def test_ranges_are_false_too_often_without_the_correction_for_looks() -> None:
    """Or the test above could not fail."""
    assert outcome(SYNTHETIC[0], looks=1, batches=10, finals=150).false_ranges > 5.0


@pytest.mark.slow
@pytest.mark.parametrize("field", [SYNTHETIC[2], SYNTHETIC[3]], ids=lambda field: field.name)
def test_ranges_are_much_narrower_on_the_same_trials(field: Field) -> None:
    same, own = outcome(field, finals=20), outcome(field, finals=20, paired=False)

    assert same.ranks < 0.6 * own.ranks


@pytest.mark.slow
def test_a_final_of_measured_entries_needs_fewer_batches_on_the_same_trials() -> None:
    field = measured("currents-v3")
    same, own = outcome(field, finals=40), outcome(field, finals=40, paired=False)

    assert same.separated == 100.0
    assert same.batches < 0.5 * own.batches


def test_a_final_ends_at_the_first_batch_that_separates_it() -> None:
    scores = normal("far apart", [0.0, 50.0]).draw(np.random.default_rng(1), 3 * BLOCKS)

    assert held(scores, looks=3)[1] == 1
    assert held(np.zeros((2, 3 * BLOCKS)) + np.eye(2, 3 * BLOCKS), looks=3)[1] == 3
