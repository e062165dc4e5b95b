"""The intervals of the service contain the mean at their nominal rate."""

import pytest

from performance.statistics.coverage import (
    BOARDS,
    SYNTHETIC,
    Scores,
    coverage,
    measured,
    rank_coverage,
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
