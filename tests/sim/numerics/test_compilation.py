"""Only what has to be compiled is announced, not what the cache has."""

from numba import njit

from seamark.sim.numerics import libm
from seamark.sim.numerics.compilation import announced


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
