"""The search: batches, methods, failures, and going on after an interruption."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import pytest

from seamark.failures import UsageRefused
from seamark.tuning.candidates import Candidate, Evaluated, Order
from seamark.tuning.history import History
from seamark.tuning.methods import method_of
from seamark.tuning.search import Search
from seamark.tuning.search_space import Dimension

SPACE = (
    Dimension(name="kp", low=0.0, high=2.0),
    Dimension(name="ki", low=0.0, high=1.0, logarithmic=True),
)
DEFAULTS = {"kp": 0.5, "ki": 0.02}
METHODS = ("bayesian", "cma-es", "random", "grid")


class Bowl:
    """An evaluator without a simulation: the best is kp 1.2, ki 0.3; kp above 1.9 crashes."""

    def __init__(self, *, backwards: bool = False, break_after: int = 10_000) -> None:
        self._backwards, self._left = backwards, break_after
        self.evaluated: list[int] = []

    def evaluate(self, orders: Sequence[Order]) -> Iterator[tuple[Order, Evaluated]]:
        for order in reversed(orders) if self._backwards else orders:
            self._left -= 1
            if self._left < 0:
                raise KeyboardInterrupt
            self.evaluated.append(order.candidate.number)
            yield order, self.repeat(order.config, seed=0, trials=1)

    def repeat(self, config: Mapping[str, Any], *, seed: int, trials: int) -> Evaluated:
        if config["kp"] > 1.9:
            return Evaluated(failure="It crashed,\nwith a comma.")
        return Evaluated(score=-((config["kp"] - 1.2) ** 2) - (config["ki"] - 0.3) ** 2)


def _search(
    method: str, evaluator: Bowl, history: History | None = None, *, limit: int = 48
) -> tuple[Search, list[int]]:
    announced: list[int] = []

    def note(candidate: Candidate, _: Evaluated) -> None:
        announced.append(candidate.number)

    search = Search(
        method=method_of(method, SPACE, start=DEFAULTS, seed=3, batch=8, limit=limit),
        evaluator=evaluator,
        configure=dict,
        history=history or History(path=None, settings={}, names=("kp", "ki")),
        on_end=note,
    )
    search.run(DEFAULTS, limit=limit, batch=8)
    return search, announced


@pytest.mark.parametrize("method", METHODS)
def test_a_search_beats_the_defaults_and_tries_no_more_than_asked(method: str) -> None:
    search, announced = _search(method, Bowl())

    best = search.best()
    assert best is not None
    assert (best[1].score or -9.0) > -0.1 > (search.ended[0][1].score or 0.0)
    assert announced == list(range(len(search.ended)))
    assert 36 <= len(search.ended) - 1 <= 48


@pytest.mark.parametrize("method", ["bayesian", "cma-es"])
def test_methods_that_learn_come_nearer_than_their_first_batches(method: str) -> None:
    search, _ = _search(method, Bowl(), limit=80)

    scores = [how.score or -9.0 for _, how in search.ended.values()]
    assert max(scores[41:]) > max(scores[:17])
    assert max(scores) > -0.005


@pytest.mark.parametrize("method", METHODS)
def test_the_order_in_which_candidates_end_makes_no_difference(method: str) -> None:
    forwards, announced = _search(method, Bowl())
    backwards, again = _search(method, Bowl(backwards=True))

    assert [forwards.ended[at] for at in announced] == [backwards.ended[at] for at in again]


@pytest.mark.parametrize("method", METHODS)
def test_an_interrupted_search_goes_on_as_if_it_had_not_been(method: str, tmp_path: Path) -> None:
    whole, _ = _search(method, Bowl())
    file = tmp_path / "history.csv"
    first, rest = Bowl(break_after=21, backwards=True), Bowl()
    with pytest.raises(KeyboardInterrupt):
        _search(method, first, History(path=file, settings={}, names=("kp", "ki")))

    history = History(path=file, settings={}, names=("kp", "ki"))
    history.load()
    resumed, _ = _search(method, rest, history)

    assert len(first.evaluated) == 21
    assert not set(first.evaluated) & set(rest.evaluated)
    assert {n: how.score for n, (_, how) in resumed.ended.items()} == {
        n: how.score for n, (_, how) in whole.ended.items()
    }


def test_candidates_that_fail_are_kept_with_their_reason_and_are_never_the_best(
    tmp_path: Path,
) -> None:
    history = History(path=tmp_path / "h.csv", settings={}, names=("kp", "ki"))

    search, _ = _search("grid", Bowl(), history)

    failed = [candidate.values["kp"] for candidate, _ in search.failed()]
    assert failed == [2.0] * 6
    again = History(path=tmp_path / "h.csv", settings={}, names=("kp", "ki"))
    again.load()
    assert again.ended(search.failed()[0][0]) == search.failed()[0][1]


def test_a_history_of_other_options_is_not_continued(tmp_path: Path) -> None:
    file = tmp_path / "h.csv"
    _search("random", Bowl(), History(path=file, settings={"seed": 1}, names=("kp", "ki")))

    with pytest.raises(UsageRefused, match="another seed"):
        History(path=file, settings={"seed": 2}, names=("kp", "ki")).load()


@pytest.mark.parametrize("text", ["", "# seamark tune {}\na\nb\n", "# seamark tune {", "\x00"])
def test_a_file_that_is_no_history_is_refused(text: str, tmp_path: Path) -> None:
    (tmp_path / "h.csv").write_text(text)

    with pytest.raises(UsageRefused, match="not the history of a tuning"):
        History(path=tmp_path / "h.csv", settings={}, names=("kp",)).load()


def test_cma_es_refuses_what_it_cannot_search() -> None:
    for space in ((SPACE[0],), (SPACE[0], Dimension(name="ki", values=(1, 2)))):
        with pytest.raises(UsageRefused, match="two or more ranges"):
            method_of("cma-es", space, start=DEFAULTS, seed=1, batch=8, limit=9)
