"""The intervals of the service contain the mean at their nominal rate."""

import numpy as np
import pytest

from performance.statistics.coverage import (
    BOARDS,
    SYNTHETIC,
    Board,
    Scores,
    coverage,
    measured,
    rank_coverage,
    separated,
)


@pytest.mark.parametrize("scores", [SYNTHETIC[0], SYNTHETIC[3]], ids=lambda each: each.name)
@pytest.mark.parametrize("trials", [10, 24])
def test_intervals_of_symmetric_scores_cover_94_to_96_percent(scores: Scores, trials: int) -> None:
    assert 94.0 <= coverage(scores, trials) <= 96.0


def test_trials_of_a_block_are_drawn_together() -> None:
    scores = measured("currents-v2 pi", [0.1, 0.3, 0.2, 0.4, 0.5])  # vehicles in turn

    assert scores.block == 2
    assert scores.mean == pytest.approx(0.25)  # the last trial has no partner


def test_ranges_of_ranks_cover_the_true_ranks() -> None:
    average, least, width = rank_coverage(BOARDS[0], 60)

    assert average >= 95.0
    assert least >= 90.0  # 95 % within the error of 60 runs
    assert width < 5.0


def test_an_interval_is_not_too_narrow_where_trials_divide_the_directions() -> None:
    assert 94.5 <= coverage(SYNTHETIC[4], 24, runs=2000) <= 99.0


@pytest.mark.parametrize(("spread", "told"), [(0.01, 100.0), (1.0, 0.0)])
def test_a_better_row_is_told_from_the_others_if_trials_are_alike(
    spread: float, told: float
) -> None:
    truth = np.array([0.5] * 4 + [0.6])
    board = Board("five rows", truth, np.full(5, spread), trials=12)

    assert separated(board, runs=20) == pytest.approx((told, told), abs=5.0)
