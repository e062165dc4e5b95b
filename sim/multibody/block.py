"""Eight mechanisms of one structure side by side, by the functions that move a single one."""

from typing import Any, TypeVar

import numpy as np
from numba import njit

from seamark.sim.multibody.step import Command, Model, State, Work, take_step
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.lanes import LANES, lanes_of
from seamark.sim.physics.current import Water, segment_at
from seamark.sim.physics.terrain import Mounds

T = TypeVar("T")


def side_by_side(parts: list[T]) -> T:
    """Return nested tuples of float64 arrays (...,) as one of arrays (..., 8).

    Integers must be the same in all of them.

    Raises
    ------
    ValueError
        Their integers differ, or there are not eight.
    """
    if len(parts) != LANES:
        raise ValueError(f"there must be {LANES} of them, not {len(parts)}")
    stacked: T = _stacked(parts)
    return stacked


def _stacked(parts: list[Any]) -> Any:
    first = parts[0]
    if isinstance(first, tuple):
        made = (_stacked(list(group)) for group in zip(*parts, strict=True))
        return type(first)(*made)
    if first.dtype == np.float64:
        return np.ascontiguousarray(np.stack(parts, axis=-1))
    if not all(np.array_equal(part, first) for part in parts):
        raise ValueError("the mechanisms of a block must have the same structure")
    return first


@njit(cache=True, error_model="numpy", nogil=True)
def advance_block(
    first: Array,
    steps: int,
    step_s: float,
    iterations: int,
    model: Model,
    state: State,
    command: Command,
    water: Water,
    ground: Mounds,
    work: Work,
) -> None:
    pass
