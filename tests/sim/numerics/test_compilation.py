"""What has to be compiled is announced; what always gets the same types is called at once."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from numba import njit

from seamark.sim.numerics import libm
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.compilation import SameTypes, announced
from tests.services.late_compilation import LateCompilation


class Line(NamedTuple):
    points: Array  # (n,)
    slope: float


@njit
def last(line: Line, at: int) -> float:
    value: float = line.points[at] * line.slope
    return value


def test_a_function_of_named_tuples_gives_the_same_when_it_is_called_at_once() -> None:
    called = SameTypes(last)
    line = Line(np.array([1.0, 2.0]), 0.5)

    first, second = called.call(line, 1), called.call(Line(np.array([4.0]), 3.0), 0)

    assert (first, second) == (last(line, 1), 12.0)
    assert len(last.signatures) == 1


def test_what_numba_compiles_is_announced_and_what_it_loads_is_not() -> None:
    libm.sin(0.5)  # in the cache from now on
    again = njit(cache=True)(libm.sin.py_func)
    counts: list[int] = []

    with announced(counts.append):
        again(0.5)
        njit(lambda x: x + 1)(2)
        njit(lambda x: x + 2)(2)
    njit(lambda x: x + 3)(2)

    assert sum(again.stats.cache_hits.values()) == 1
    assert counts == [1, 2]


def test_what_is_compiled_late_is_listed_by_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    late = LateCompilation()
    before = late.functions()

    njit(cache=True)(libm.sin.py_func)(0.5)

    assert (before, late.functions(), LateCompilation().functions()) == ([], ["libm.sin"], [])
