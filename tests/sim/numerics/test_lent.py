"""Tuples that are lent to compiled code as words, and recalled there."""

from typing import Any, NamedTuple

import numpy as np
import pytest
from numba import njit
from numpy.typing import NDArray

from seamark.sim.numerics.lent import Lent, lend, recalled, taken


class Thing(NamedTuple):
    """Of all kinds that can be lent."""

    plane: NDArray[np.float32]
    number: int
    flag: bool
    share: float


Value = tuple[tuple[Thing, NDArray[np.int64]], float]


def value(k: int) -> Value:
    plane = np.arange(6, dtype=np.float32).reshape(2, 3) * k
    return (Thing(plane, -k, bool(k % 2), 0.25 * k), np.arange(k + 1)), 1e300 * k


@njit
def told(table: NDArray[np.int64], like: Any, out: NDArray[np.float64]) -> None:
    for i in range(table.shape[0]):
        (thing, counts), big = recalled(table[i], like)
        out[i, 0], out[i, 1] = thing.plane[1, 2], thing.number
        out[i, 2], out[i, 3] = 1.0 if thing.flag else 0.0, thing.share
        out[i, 4], out[i, 5] = counts.sum(), big
        thing.plane[0, 0] = i + 10


def test_what_is_recalled_is_what_was_lent_and_can_be_written_to() -> None:
    owners = [value(k) for k in range(4)]
    out = np.empty((4, 6))

    told(np.array([lend(each) for each in owners]), owners[0], out)

    for k, row in enumerate(out):
        assert row.tolist() == [5.0 * k, -k, k % 2, 0.25 * k, sum(range(k + 1)), 1e300 * k]
        assert owners[k][0][0].plane[0, 0] == k + 10


@njit
def told_at_once(lent: Lent[Value], more: int) -> float:
    (thing, counts), big = taken(lent)
    thing.plane[0, 0] += more
    return thing.plane[1, 2] + thing.number + thing.share + counts.sum() + big / 1e300


def test_what_is_taken_is_the_present_value_of_what_was_lent() -> None:
    first, second = value(1), value(2)
    one, other = Lent(first), Lent(second)
    first[0][0].plane[1, 2] = 7.0

    assert told_at_once(one, 3) == 7.0 - 1.0 + 0.25 + 1.0 + 1.0
    assert told_at_once(other, 4) == 10.0 - 2.0 + 0.5 + 3.0 + 2.0
    assert (first[0][0].plane[0, 0], second[0][0].plane[0, 0]) == (3.0, 4.0)


@pytest.mark.parametrize("refused", ["text", np.zeros((4, 4))[:, 1], (1, None)])
def test_what_cannot_be_lent_is_refused(refused: Any) -> None:
    with pytest.raises(TypeError, match="cannot be lent"):
        lend(refused)
