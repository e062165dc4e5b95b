"""Ranks of a final: the paired differences decide, in whatever order the finalists come.

tests/performance/statistics/test_finals.py has how often the ranges are right.
"""

import math
import random
from collections.abc import Sequence
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from seamark.competitions.standings import Finalist, Placing, Standings, Ties, decide
from seamark.sim.numerics.statistics import mean, paired_interval, standard_error

NOISE = (0.1, -0.2, 0.3, 0.0, -0.1, 0.2, -0.3, 0.05, 0.15, -0.2, 0.1, -0.1)  # of twelve trials
OTHER = (0.0, 0.1, -0.1, 0.2, -0.2, 0.1, 0.0, -0.1, 0.1, 0.0, -0.2, 0.1)
WHOLE = st.integers(-20, 20).map(float)  # sums of whole numbers are exact
TABLE = st.integers(1, 8).flatmap(
    lambda count: st.lists(
        st.none() | st.lists(WHOLE, min_size=8, max_size=8), min_size=count, max_size=count
    )
)
RULE = st.sampled_from(Ties)


def finalists(rows: Sequence[Sequence[float] | None]) -> list[Finalist]:
    """Return finalists with their place in the list as key and as time of submission."""
    return [
        Finalist(key=at, submitted_at=float(at), scores=scores) for at, scores in enumerate(rows)
    ]


def places(standings: Standings) -> dict[int, tuple[int | None, int | None, int | None]]:
    return {one.key: (one.place, one.place_low, one.place_high) for one in standings.placings}


def shifted(scores: Sequence[float], by: float) -> list[float]:
    return [score + by for score in scores]


def by_key(standings: Standings) -> list[Placing]:
    return sorted(standings.placings, key=lambda one: one.key)


def test_the_better_of_two_is_first_if_the_differences_say_so() -> None:
    rows = finalists([NOISE, shifted(OTHER, 1.0)])

    standings = decide(rows, block=1, looks=1, ties=Ties.EARLIER)

    assert places(standings) == {1: (1, 1, 1), 0: (2, 2, 2)}
    assert [one.key for one in standings.placings] == [1, 0]
    assert standings.separated


@pytest.mark.parametrize(("factor", "separated"), [(0.999, False), (1.001, True)])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_two_finalists_are_apart_exactly_if_the_paired_interval_excludes_zero(
    factor: float, separated: bool, sign: float
) -> None:
    low, high = paired_interval(OTHER, NOISE, block=2) or (math.nan, math.nan)
    difference, margin = 0.5 * (low + high), 0.5 * (high - low)
    first = shifted(OTHER, sign * factor * margin - difference)

    standings = decide(finalists([first, NOISE]), block=2, looks=1, ties=Ties.EARLIER)

    assert standings.separated == separated
    assert standings.placings[0].place_high == (1 if separated else 2)
    assert standings.placings[1].place_low == (2 if separated else 1)


def test_each_look_that_may_come_widens_the_ranges() -> None:
    rows = finalists([shifted(OTHER, 0.17), NOISE])

    once = decide(rows, block=1, looks=1, ties=Ties.EARLIER)
    often = decide(rows, block=1, looks=50, ties=Ties.EARLIER)

    assert once.separated
    assert places(often) == {0: (1, 1, 2), 1: (2, 1, 2)}
    assert often.placings[0].score_low == once.placings[0].score_low


def test_more_finalists_widen_the_ranges_of_two() -> None:
    far = [[50.0 * number] * 11 + [50.0 * number + 1.0] for number in range(1, 30)]

    alone = decide(finalists([shifted(OTHER, 0.17), NOISE]), block=1, looks=1, ties=Ties.EARLIER)
    among = decide(
        finalists([shifted(OTHER, 0.17), NOISE, *far]), block=1, looks=1, ties=Ties.EARLIER
    )

    assert alone.separated
    assert not among.separated
    assert places(among)[0] == (30, 30, 31)


def test_what_the_trials_do_not_tell_apart_is_ordered_by_score_or_shares_a_place() -> None:
    """The third is worse than the first two, which are alike."""
    rows = finalists([shifted(NOISE, 5.0), shifted(OTHER, 4.99), [0.0, *NOISE[1:]]])

    ordered = decide(rows, block=1, looks=1, ties=Ties.EARLIER)
    shared = decide(rows, block=1, looks=1, ties=Ties.SHARED)

    assert [(one.key, one.place) for one in ordered.placings] == [(0, 1), (1, 2), (2, 3)]
    assert [(one.key, one.place) for one in shared.placings] == [(0, 1), (1, 1), (2, 3)]
    assert {(one.place_low, one.place_high) for one in ordered.placings} == {(1, 2), (3, 3)}


def test_a_steady_finalist_may_be_worse_than_the_best_and_an_unsteady_one_below_it_not() -> None:
    """Places that are shared follow what is significant, those by score the score."""
    best, steady = shifted(NOISE, 5.0), shifted(OTHER, 4.0)
    unsteady = [value * 40.0 + 3.5 for value in NOISE]
    rows = finalists([unsteady, steady, best])

    ordered = decide(rows, block=1, looks=1, ties=Ties.EARLIER)
    shared = decide(rows, block=1, looks=1, ties=Ties.SHARED)

    assert [(one.key, one.place) for one in ordered.placings] == [(2, 1), (1, 2), (0, 3)]
    assert [(one.key, one.place) for one in shared.placings] == [(2, 1), (0, 1), (1, 2)]


def test_of_equal_scores_the_earlier_submission_is_first() -> None:
    late = Finalist(key=1, submitted_at=200.0, scores=NOISE)
    early = Finalist(key=2, submitted_at=100.0, scores=NOISE[::-1])

    standings = decide([late, early], block=1, looks=1, ties=Ties.EARLIER)

    assert [one.key for one in standings.placings] == [2, 1]
    assert not standings.separated


def test_two_copies_of_a_program_do_not_keep_a_final_going() -> None:
    rows = finalists([NOISE, NOISE, shifted(OTHER, -3.0)])

    standings = decide(rows, block=1, looks=5, ties=Ties.EARLIER)

    assert standings.separated
    assert places(standings) == {0: (1, 1, 2), 1: (2, 1, 2), 2: (3, 3, 3)}
    shared = decide(rows, block=1, looks=5, ties=Ties.SHARED)
    assert places(shared) == {0: (1, 1, 2), 1: (1, 1, 2), 2: (3, 3, 3)}


def test_a_failed_finalist_is_last_and_costs_the_others_no_comparison() -> None:
    rows = [shifted(OTHER, 0.17), NOISE]

    with_failed = decide(finalists([*rows, None, None]), block=1, looks=1, ties=Ties.EARLIER)

    assert with_failed.separated
    assert [one.key for one in with_failed.placings] == [0, 1, 2, 3]
    assert with_failed.placings[2] == Placing(
        key=2, place=None, place_low=None, place_high=None,
        score=None, score_low=None, score_high=None,
    )  # fmt: skip
    alone = decide(finalists(rows), block=1, looks=1, ties=Ties.EARLIER)
    assert with_failed.placings[:2] == alone.placings


@pytest.mark.parametrize("rows", [[], [None], [None, NOISE]])
def test_nothing_is_left_to_separate_among_fewer_than_two(
    rows: list[Sequence[float] | None],
) -> None:
    standings = decide(finalists(rows), block=1, looks=1, ties=Ties.EARLIER)

    assert standings.separated
    assert [one.place for one in standings.placings if one.score is not None] == [1][
        : len(rows) - 1
    ]


def test_a_single_block_says_nothing() -> None:
    standings = decide(finalists([[1.0, 2.0], [5.0, 7.0]]), block=2, looks=1, ties=Ties.EARLIER)

    assert places(standings) == {1: (1, 1, 2), 0: (2, 1, 2)}
    assert standings.placings[0].score_low is None
    assert not standings.separated


def test_differences_without_a_spread_count_only_with_enough_blocks() -> None:
    """Two equal programs whose trials succeed or fail by chance differ so in one of 2**n finals."""
    few = decide(finalists([[1.0] * 5, [0.0] * 5]), block=1, looks=1, ties=Ties.EARLIER)
    enough = decide(finalists([[1.0] * 6, [0.0] * 6]), block=1, looks=1, ties=Ties.EARLIER)
    looks = decide(finalists([[1.0] * 6, [0.0] * 6]), block=1, looks=2, ties=Ties.EARLIER)

    assert (few.separated, enough.separated, looks.separated) == (False, True, False)


@pytest.mark.parametrize("size", [1.0, 1e8])
def test_a_difference_that_is_only_rounding_separates_nothing(size: float) -> None:
    first = [(0.1 + 0.2) * size] * 12
    second = [0.3 * size] * 12
    assert first != second

    standings = decide(finalists([second, first]), block=1, looks=1, ties=Ties.EARLIER)

    assert {(one.place_low, one.place_high) for one in standings.placings} == {(1, 2)}


def test_the_score_of_a_finalist_is_the_mean_with_its_interval() -> None:
    placing = decide(finalists([NOISE]), block=1, looks=1, ties=Ties.EARLIER).placings[0]

    assert placing.score == mean(NOISE)
    half = 2.200985 * standard_error(NOISE)  # t of 11 degrees of freedom
    assert placing.score_high == pytest.approx(mean(NOISE) + half, rel=1e-6)
    assert placing.score_low == pytest.approx(mean(NOISE) - half, rel=1e-6)


@given(table=TABLE, ties=RULE, seed=st.randoms())
def test_the_order_of_the_input_does_not_matter(
    table: list[list[float] | None], ties: Ties, seed: random.Random
) -> None:
    rows = finalists(table)
    other = list(rows)
    seed.shuffle(other)

    assert decide(other, block=2, looks=3, ties=ties) == decide(rows, block=2, looks=3, ties=ties)


@given(table=TABLE, ties=RULE, constant=st.integers(-1000, 1000))
def test_a_constant_that_is_added_to_all_scores_changes_no_place(
    table: list[list[float] | None], ties: Ties, constant: int
) -> None:
    other = [None if row is None else shifted(row, float(constant)) for row in table]

    before = decide(finalists(table), block=2, looks=3, ties=ties)
    after = decide(finalists(other), block=2, looks=3, ties=ties)

    assert places(after) == places(before)
    assert after.separated == before.separated


@given(table=TABLE, ties=RULE, water=st.lists(WHOLE, min_size=8, max_size=8))
def test_what_a_trial_gives_to_all_changes_no_place(
    table: list[list[float] | None], ties: Ties, water: list[float]
) -> None:
    other = [
        None if row is None else [a + b for a, b in zip(row, water, strict=True)] for row in table
    ]

    before = decide(finalists(table), block=2, looks=3, ties=ties)
    after = decide(finalists(other), block=2, looks=3, ties=ties)

    assert places(after) == places(before)


@given(table=TABLE)
def test_the_opposite_scores_turn_the_ranges_round(table: list[list[float] | None]) -> None:
    other = [None if row is None else [-score for score in row] for row in table]
    ran = sum(row is not None for row in table)

    before = by_key(decide(finalists(table), block=1, looks=2, ties=Ties.EARLIER))
    after = by_key(decide(finalists(other), block=1, looks=2, ties=Ties.EARLIER))

    for one, turned in zip(before, after, strict=True):
        if one.place_low is not None and one.place_high is not None:
            assert turned.place_low == ran + 1 - one.place_high
            assert turned.place_high == ran + 1 - one.place_low


@given(table=TABLE, ties=RULE)
def test_a_place_is_within_its_range_and_all_places_are_there(
    table: list[list[float] | None], ties: Ties
) -> None:
    standings = decide(finalists(table), block=4, looks=1, ties=ties)

    ran = [one for one in standings.placings if one.place is not None]
    for one in ran:
        assert 1 <= (one.place_low or 0) <= (one.place or 0) <= (one.place_high or 0) <= len(ran)
    ordered = {Ties.EARLIER: list(range(1, len(ran) + 1)), Ties.SHARED: [o.place for o in ran]}
    assert [one.place for one in ran] == ordered[ties]
    assert [one.place or 0 for one in ran] == sorted(one.place or 0 for one in ran)


@pytest.mark.parametrize(
    ("rows", "block", "looks", "word"),
    [
        ([[1.0, 2.0], [1.0]], 1, 1, "different numbers of trials"),
        ([[1.0, 2.0, 3.0]], 2, 1, "complete blocks"),
        ([[]], 1, 1, "complete blocks"),
        ([[1.0, math.nan]], 1, 1, "not finite"),
        ([[1.0, math.inf]], 1, 1, "not finite"),
        ([[1.0, 2.0]], 0, 1, "at least 1"),
        ([[1.0, 2.0]], 1, 0, "at least 1"),
    ],
)
def test_scores_that_cannot_be_compared_are_an_error(
    rows: list[list[float]], block: int, looks: int, word: str
) -> None:
    with pytest.raises(ValueError, match=word):
        decide(finalists(rows), block=block, looks=looks, ties=Ties.EARLIER)


def test_two_finalists_with_the_same_key_are_an_error() -> None:
    one = finalists([NOISE])[0]

    with pytest.raises(ValueError, match="twice"):
        decide([one, replace(one, submitted_at=5.0)], block=1, looks=1, ties=Ties.EARLIER)
