"""A histogram of the scores on each leaderboard: how many rows are in which narrow class.

A leaderboard may have a million rows, and the range of ranks of one row depends on all the others.
There are some thousands of classes at most; they are updated with the rows, in one transaction.
People and methods are counted apart.

A class of scores is 1/256 of an octave wide: 0.125 between 32 and 64, 0.002 between 0.5 and 1. A
class of standard errors is half an octave wide. The bounds of classes of scores are exact in binary
arithmetic, so that Python and SQL put a score into the same class.
"""

import math
from collections import Counter
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import ColumnElement, and_, delete, func, insert, select, update
from sqlalchemy.orm import Session

from seamark.server.database.publication_tables import ScoreCount
from seamark.server.runs.leaderboard.per import Per
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.ranking import Estimate, Population

SINGLE_ROWS = 2000  # compare every row up to this many people, every class above
CLASSES_PER_OCTAVE = 256
LOWEST_EXPONENT, HIGHEST_EXPONENT = -10, 20  # scores below 2**-10, and negative ones: class 0
ERRORS_PER_OCTAVE = 2
UNKNOWN_ERROR = 1000  # class of scores without a standard error
_HIGHEST_CLASS = (HIGHEST_EXPONENT - LOWEST_EXPONENT) * CLASSES_PER_OCTAVE + 1
_LARGEST_ERROR_CLASS = 100  # standard errors above 2**50 count as unknown

Key = tuple[int, int, int]  # class of the score, class of the standard error, degrees of freedom
_NUMBERS = {Per.PERSON: ScoreCount.people, Per.METHOD: ScoreCount.methods}
Counts = Counter[tuple[str, Key, Per]]  # benchmark, class and what is counted -> rows


def score_class(score: float) -> int:
    """Return the class of a score; a higher score never has a lower class."""
    if score < 2.0**LOWEST_EXPONENT:
        return 0
    mantissa, exponent = math.frexp(score)  # score = mantissa * 2**exponent, mantissa >= 0.5
    octave = exponent - 1 - LOWEST_EXPONENT
    within = math.floor((2.0 * mantissa - 1.0) * CLASSES_PER_OCTAVE)
    return min(octave * CLASSES_PER_OCTAVE + within + 1, _HIGHEST_CLASS)


def lower_ends(classes: NDArray[np.int64]) -> Array:
    """Return the lowest score of each class; a class ends where the next one begins."""
    octave, within = np.divmod(classes - 1, CLASSES_PER_OCTAVE)
    inside = np.ldexp(1.0 + within / CLASSES_PER_OCTAVE, octave + LOWEST_EXPONENT)
    beyond = np.where(classes > _HIGHEST_CLASS, math.inf, inside)
    return np.where(classes < 1, -math.inf, beyond)


def error_class(standard_error: float | None) -> int:
    """Return the class of a standard error: at most 2**(class / ERRORS_PER_OCTAVE)."""
    if standard_error is None:
        return UNKNOWN_ERROR
    smallest = 2.0 ** (-_LARGEST_ERROR_CLASS / ERRORS_PER_OCTAVE)
    number = math.ceil(ERRORS_PER_OCTAVE * math.log2(max(standard_error, smallest)))
    return UNKNOWN_ERROR if number > _LARGEST_ERROR_CLASS else number


def key_of(row: Estimate) -> Key:
    """Return the class that a row is counted in."""
    return score_class(row.score), error_class(row.standard_error), row.degrees


def change(session: Session, counts: Counts) -> None:
    """Count some rows more, or less, in their classes. The caller holds the leaderboard's lock."""
    for (benchmark, key, per), by in counts.items():
        if by == 0:
            continue
        in_class = _in_class(benchmark, key)
        changed = update(ScoreCount).where(in_class).values({_NUMBERS[per]: _NUMBERS[per] + by})
        if session.scalar(changed.returning(_NUMBERS[per])) is None:
            session.execute(insert(ScoreCount).values(_row(benchmark, key, {per: by})))
        empty = (ScoreCount.people == 0, ScoreCount.methods == 0)
        session.execute(delete(ScoreCount).where(in_class, *empty))


def replace_all(session: Session, counts: Counts) -> None:
    """Store the counts of all benchmarks."""
    session.execute(delete(ScoreCount))
    classes = {(benchmark, key) for benchmark, key, _ in counts}
    rows = [
        _row(benchmark, key, {per: counts[benchmark, key, per] for per in Per})
        for benchmark, key in classes
    ]
    if rows:
        session.execute(insert(ScoreCount), rows)


def numbers(session: Session, benchmark: str) -> dict[Per, int]:
    """Return how many people and how many methods are on a leaderboard."""
    sums = select(*(func.sum(_NUMBERS[per]) for per in Per))
    row = session.execute(sums.where(ScoreCount.benchmark == benchmark)).one()
    return {per: int(number or 0) for per, number in zip(Per, row, strict=True)}


def size(session: Session, benchmark: str) -> int:
    """Return the number of people on a leaderboard."""
    return numbers(session, benchmark)[Per.PERSON]


def sizes(session: Session) -> dict[str, int]:
    """Return the `size` of each leaderboard that has anybody on it."""
    people = select(ScoreCount.benchmark, func.sum(ScoreCount.people))
    return {
        name: int(count) for name, count in session.execute(people.group_by(ScoreCount.benchmark))
    }


def at_or_above(
    session: Session,
    benchmark: str,
    score: float,
    *,
    not_below: ColumnElement[bool],
    per: Per = Per.PERSON,
) -> int:
    """Return the number of people or methods at or above a row of the leaderboard.

    Parameters
    ----------
    score
        Of that row.
    not_below
        Condition on rows of `per.table`: at or above that row. It decides within the row's own
        class.
    """
    table = per.table
    own_class = score_class(score)
    low, high = lower_ends(np.array([own_class, own_class + 1])).tolist()
    higher = select(func.sum(_NUMBERS[per])).where(
        ScoreCount.benchmark == benchmark, ScoreCount.score_class > own_class
    )
    same = select(func.count()).where(
        table.benchmark == benchmark, table.score >= low, table.score < high, ~table.is_baseline
    )
    both = select(higher.scalar_subquery(), same.where(not_below).scalar_subquery())
    rows_higher, rows_same = session.execute(both).one()
    return int(rows_higher or 0) + int(rows_same)


def population(
    session: Session,
    benchmark: str,
    per: Per = Per.PERSON,
    *,
    number: int | None = None,
    single_rows: int = SINGLE_ROWS,
) -> Population:
    """Return the scores of all rows: each one, or each class if there are more than that.

    `number` is how many there are, if the caller knows it.
    """
    if number is None:
        number = numbers(session, benchmark)[per]
    if number <= single_rows:
        return _of_rows(session, benchmark, per)
    columns = (ScoreCount.score_class, ScoreCount.error_class, ScoreCount.degrees)
    query = select(*columns, _NUMBERS[per]).where(
        ScoreCount.benchmark == benchmark, _NUMBERS[per] > 0
    )
    rows = np.array([tuple(row) for row in session.execute(query)], dtype=np.int64)
    score_classes, error_classes, degrees, counts = rows.T
    largest_errors = np.exp2(error_classes / ERRORS_PER_OCTAVE)
    return Population(
        low=lower_ends(score_classes),
        high=lower_ends(score_classes + 1),
        standard_error=np.where(error_classes == UNKNOWN_ERROR, math.inf, largest_errors),
        degrees=degrees.astype(float),
        counts=counts,
    )


def _of_rows(session: Session, benchmark: str, per: Per) -> Population:
    table = per.table
    query = select(table.score, table.standard_error, table.degrees)
    rows = session.execute(query.where(table.benchmark == benchmark, ~table.is_baseline)).all()
    score, error, degrees = np.array([tuple(row) for row in rows], dtype=float).reshape(-1, 3).T
    return Population(
        low=score,
        high=score,
        standard_error=np.where(np.isnan(error), math.inf, error),  # None became nan
        degrees=degrees,
        counts=np.ones(len(rows), dtype=np.int64),
    )


def _row(benchmark: str, key: Key, counts: Mapping[Per, int]) -> dict[str, str | int]:
    columns = ("score_class", "error_class", "degrees")
    numbers = {_NUMBERS[per].key: counts.get(per, 0) for per in Per}
    return {"benchmark": benchmark, **dict(zip(columns, key, strict=True)), **numbers}


def _in_class(benchmark: str, key: Key) -> ColumnElement[bool]:
    score, error, degrees = key
    return and_(
        ScoreCount.benchmark == benchmark,
        ScoreCount.score_class == score,
        ScoreCount.error_class == error,
        ScoreCount.degrees == degrees,
    )
