"""Trees are read safely in many threads."""

import sys
from concurrent.futures import ThreadPoolExecutor

import pytest

from seamark.sim.metrics.syntax_trees import expression_of, module_of

NESTED = "x = " + "(" * 40 + "1" + " + 1)" * 40


@pytest.fixture
def threads_that_take_turns_often() -> object:
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    yield
    sys.setswitchinterval(before)


@pytest.mark.usefixtures("threads_that_take_turns_often")
def test_many_threads_can_parse_at_the_same_time() -> None:
    with ThreadPoolExecutor(8) as pool:
        trees = list(pool.map(lambda _: module_of(NESTED, "a.py"), range(400)))
        values = list(pool.map(lambda _: expression_of("a + b"), range(400)))

    assert len({len(tree.body) for tree in trees}) == 1
    assert len(values) == 400
