"""Trees are read safely in many threads."""

import sys
from concurrent.futures import ThreadPoolExecutor

import pytest

from seamark.sim.metrics.syntax_trees import expression_of

NESTED = "(" * 40 + "1" + " + 1)" * 40


@pytest.fixture
def threads_that_take_turns_often() -> object:
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    yield
    sys.setswitchinterval(before)


@pytest.mark.usefixtures("threads_that_take_turns_often")
def test_many_threads_can_parse_at_the_same_time() -> None:
    with ThreadPoolExecutor(8) as pool:
        trees = list(pool.map(lambda _: expression_of(NESTED), range(800)))

    assert {type(tree.body).__name__ for tree in trees} == {"BinOp"}
    assert len(trees) == 800
