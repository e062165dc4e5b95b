"""Ranges of ranks: as narrow as the scores allow, and the true rank inside."""

import numpy as np
import pytest

from seamark.sim.numerics.ranking import Estimate, Population
from seamark.sim.numerics.student_t import quantile

Row = tuple[float, float, int]  # score, standard error, degrees of freedom


def _population(rows: list[Row]) -> Population:
    score, error, degrees = np.array(rows, dtype=float).T
    people = np.ones(len(rows), dtype=np.int64)
    return Population(low=score, high=score, standard_error=error, degrees=degrees, counts=people)


def _ranges(rows: list[Row]) -> list[tuple[int, int]]:
    people = _population(rows)
    return [
        people.rank_range(Estimate(score=score, standard_error=error, degrees=degrees))
        for score, error, degrees in rows
    ]


def test_25_rows_whose_neighbours_overlap_are_not_all_first() -> None:
    error = 0.22 / quantile(0.025, 9)  # 95 % intervals of +-0.22 from ten trials
    ranges = _ranges([(50.0 - 0.3 * index, error, 9) for index in range(25)])

    assert ranges[0] == (1, 2)
    assert ranges[12] == (12, 14)
    assert ranges[24] == (24, 25)
    assert all(low <= rank <= high for rank, (low, high) in enumerate(ranges, start=1))


def test_only_rows_that_differ_significantly_bound_a_rank() -> None:
    precise, vague = (60.0, 0.1, 9), (50.0, 30.0, 9)

    assert _ranges([precise, (40.0, 0.1, 9)]) == [(1, 1), (2, 2)]
    assert _ranges([precise, vague]) == [(1, 2), (1, 2)]


def test_equal_rows_share_all_their_ranks() -> None:
    assert _ranges([(50.0, 0.0, 9)] * 3 + [(40.0, 0.0, 9)]) == [(1, 3)] * 3 + [(4, 4)]


def test_a_row_of_unknown_error_may_have_any_rank_and_bounds_no_other() -> None:
    people = _population([(90.0, np.inf, 0), (50.0, 0.1, 9), (40.0, 0.1, 9)])

    unknown = Estimate(score=90.0, standard_error=None, degrees=0)
    assert people.rank_range(unknown) == (1, 3)
    assert people.rank_range(Estimate(score=50.0, standard_error=0.1, degrees=9)) == (1, 2)


def test_who_is_alone_is_first() -> None:
    assert _ranges([(50.0, 0.1, 9)]) == [(1, 1)]


@pytest.mark.parametrize("spacing", [0.0, 0.1, 0.5, 1.5])
def test_the_true_rank_is_in_the_range_at_least_at_the_confidence(spacing: float) -> None:
    generator = np.random.default_rng(5)
    truth = np.array([50.0 - spacing * index for index in range(12)])
    covered = np.zeros(len(truth))
    runs = 250
    for _ in range(runs):
        trials = generator.normal(truth[:, None], np.linspace(0.3, 2.0, 12)[:, None], (12, 10))
        means, errors = np.mean(trials, axis=1), np.std(trials, axis=1, ddof=1) / np.sqrt(10)
        rows = [(float(m), float(e), 9) for m, e in np.column_stack((means, errors))]
        for index, (low, high) in enumerate(_ranges(rows)):
            first = 1 + int(np.sum(truth > truth[index]))  # rows of the same truth share ranks
            last = int(np.sum(truth >= truth[index]))
            covered[index] += low <= first <= last <= high

    assert np.min(covered) / runs >= 0.93  # 95 % within the error of 250 runs
    assert np.mean(covered) / runs >= 0.95
