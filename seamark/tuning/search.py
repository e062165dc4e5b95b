"""The search: asks for candidates in batches, has them run, and keeps the best."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from seamark.sim.settings.refusal import ConfigurationInvalid
from seamark.tuning.candidates import DEFAULTS, Candidate, Evaluated, Evaluator, Order
from seamark.tuning.history import History
from seamark.tuning.methods import Method
from seamark.tuning.search_space import Value

Configure = Callable[[Mapping[str, Value]], Mapping[str, Any]]
OnEnd = Callable[[Candidate, Evaluated], None]


@dataclass(slots=True, kw_only=True)
class Search:
    """A search for the best values of some parameters.

    `configure` returns the configuration of a run with these values, or raises
    ConfigurationInvalid. `on_end` gets the candidates in their order, however they end.
    """

    method: Method
    evaluator: Evaluator
    configure: Configure
    history: History
    on_end: OnEnd
    ended: dict[int, tuple[Candidate, Evaluated]] = field(default_factory=dict)  # by number
    announced: int = 0  # candidates that `on_end` got

    def run(self, defaults: Mapping[str, Value], *, limit: int, batch: int) -> None:
        """Try the defaults and up to `limit` candidates, `batch` at a time."""
        waiting = [Candidate(number=DEFAULTS, values=defaults)]
        number = DEFAULTS + 1
        while True:
            count = min(batch, limit - number + 1)
            asked = [
                Candidate(number=number + at, values=values)
                for at, values in enumerate(self.method.ask(count) if count > 0 else [])
            ]
            self._evaluate([*waiting, *asked])
            if not asked:
                return
            self.method.tell([self.ended[one.number][1].score for one in asked])
            waiting, number = [], number + len(asked)

    def best(self) -> tuple[Candidate, Evaluated] | None:
        """Return the candidate with the highest score, the first of equal ones."""
        scored = [pair for _, pair in sorted(self.ended.items()) if pair[1].score is not None]
        return max(scored, key=lambda pair: pair[1].score or 0.0, default=None)

    def failed(self) -> list[tuple[Candidate, Evaluated]]:
        """Return the candidates without a score."""
        return [pair for _, pair in sorted(self.ended.items()) if pair[1].score is None]

    def _evaluate(self, batch: Sequence[Candidate]) -> None:
        """Run what has not run before; afterwards all of the batch have ended."""
        orders: list[Order] = []
        for candidate in batch:
            if (earlier := self.history.ended(candidate)) is not None:
                self._end(candidate, earlier)
                continue
            try:
                config = self.configure(candidate.values)
            except ConfigurationInvalid as invalid:
                self._keep(candidate, Evaluated(failure=f"Not allowed: {invalid}"))
                continue
            orders.append(Order(candidate=candidate, config=config))
        for order, evaluated in self.evaluator.evaluate(orders):
            self._keep(order.candidate, evaluated)

    def _keep(self, candidate: Candidate, evaluated: Evaluated) -> None:
        self.history.add(candidate, evaluated)
        self._end(candidate, evaluated)

    def _end(self, candidate: Candidate, evaluated: Evaluated) -> None:
        self.ended[candidate.number] = (candidate, evaluated)
        while (pair := self.ended.get(self.announced)) is not None:
            self.on_end(*pair)
            self.announced += 1
