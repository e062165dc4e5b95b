"""How candidates are chosen. A method is asked for a batch, then told all scores of the batch.

So what it proposes depends on its seed and on the size of a batch, but neither on the number of
processes nor on which candidate ends first.
"""

from __future__ import annotations

import itertools
import math
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol

from seamark.failures import UsageRefused
from seamark.tuning.search_space import Dimension, Value

if TYPE_CHECKING:
    from optuna.distributions import BaseDistribution
    from optuna.trial import Trial

Values = dict[str, Value]
FAILED = -1e12  # score of a candidate without one; the methods only compare scores
CMA_ES_SIGMA = 0.25  # first standard deviation, as a share of each range; E


class Method(Protocol):
    """A way to choose candidates."""

    def ask(self, count: int) -> list[Values]:
        """Return up to `count` candidates; fewer if there are no more."""

    def tell(self, scores: Sequence[float | None]) -> None:
        """Take the scores of the last batch, in its order; None: it failed."""


class Grid:
    """All combinations of equally spaced values, in order; the last parameter varies fastest."""

    def __init__(self, space: Sequence[Dimension], *, limit: int) -> None:
        """Space `limit` or fewer candidates evenly."""
        lists = math.prod(len(one.values) for one in space if one.values)
        ranges = sum(not one.values for one in space)
        count = _root(limit // lists, ranges)
        if count < 1 or (ranges and count < 2):
            raise UsageRefused(
                f"--candidates {limit} is too few for a grid over {len(space)} parameters."
            )
        names = [one.name for one in space]
        combinations = itertools.product(*(one.grid(count) for one in space))
        self._left: Iterator[Values] = (dict(zip(names, one, strict=True)) for one in combinations)

    def ask(self, count: int) -> list[Values]:
        """Return the next combinations."""
        return list(itertools.islice(self._left, count))

    def tell(self, scores: Sequence[float | None]) -> None:
        """Ignore the scores."""


def _root(number: int, degree: int) -> int:
    """Return the largest whole number whose power is at most `number`."""
    root = 1
    while degree and (root + 1) ** degree <= number:
        root += 1
    return root if number >= 1 else 0


class CmaEs:
    """Covariance matrix adaptation evolution strategy, of ranges only.

    N. Hansen, A. Ostermeier, Completely derandomized self-adaptation in evolution strategies,
    Evolutionary Computation 9 (2001). The first mean is that of the values without tuning.
    """

    def __init__(
        self, space: Sequence[Dimension], *, start: Mapping[str, Value], seed: int, batch: int
    ) -> None:
        import numpy as np
        from cmaes import CMA

        if any(one.values for one in space) or len(space) < 2:
            raise UsageRefused(
                "CMA-ES tunes two or more ranges of numbers. Use --method bayesian for lists of "
                "values, and for one parameter."
            )
        if batch < 3:
            raise UsageRefused("CMA-ES needs a --batch of three or more.")
        self._space = space
        self._optimiser = CMA(
            mean=np.array([one.share_of(float(start[one.name])) for one in space]),
            sigma=CMA_ES_SIGMA,
            bounds=np.tile([0.0, 1.0], (len(space), 1)),
            seed=seed,
            population_size=batch,
        )
        self._asked: list[Any] = []

    def ask(self, count: int) -> list[Values]:
        """Return candidates of the present generation."""
        self._asked = [self._optimiser.ask() for _ in range(count)]
        return [
            {one.name: one.value_at(float(x)) for one, x in zip(self._space, point, strict=True)}
            for point in self._asked
        ]

    def tell(self, scores: Sequence[float | None]) -> None:
        """Adapt to the scores of a generation; an incomplete one is the last."""
        if len(scores) == self._optimiser.population_size:
            losses = [-FAILED if score is None else -score for score in scores]
            self._optimiser.tell(list(zip(self._asked, losses, strict=True)))


class Sampled:
    """Samplers of Optuna: uniform, or by a model of the scores so far.

    The model is a tree-structured Parzen estimator (J. Bergstra et al., Algorithms for
    hyper-parameter optimization, NIPS 2011), of all parameters jointly. Candidates of the same
    batch count as bad until their scores are known, so that they spread.
    """

    def __init__(self, space: Sequence[Dimension], *, seed: int, by_model: bool) -> None:
        import optuna

        self._space = space
        optuna.logging.set_verbosity(optuna.logging.WARNING)
        sampler: optuna.samplers.BaseSampler = optuna.samplers.RandomSampler(seed=seed)
        if by_model:
            with warnings.catch_warnings():  # both options have been experimental since 2021
                warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
                sampler = optuna.samplers.TPESampler(
                    seed=seed, multivariate=True, constant_liar=True
                )
        self._study = optuna.create_study(direction="maximize", sampler=sampler)
        self._asked: list[Trial] = []

    def ask(self, count: int) -> list[Values]:
        """Return new candidates."""
        distributions = {one.name: _distribution(one) for one in self._space}
        self._asked = [self._study.ask(distributions) for _ in range(count)]
        return [
            {
                one.name: _listed(one, asked.params[one.name])
                if one.values
                else one.value_at(asked.params[one.name])
                for one in self._space
            }
            for asked in self._asked
        ]

    def tell(self, scores: Sequence[float | None]) -> None:
        """Add the scores to the model."""
        for asked, score in zip(self._asked, scores, strict=True):
            self._study.tell(asked, FAILED if score is None else score)


def _distribution(one: Dimension) -> BaseDistribution:
    from optuna.distributions import CategoricalDistribution, FloatDistribution

    if one.values:
        return CategoricalDistribution(tuple(range(len(one.values))))
    return FloatDistribution(0.0, 1.0)


def _listed(one: Dimension, position: int) -> Value:
    return one.values[position]


def method_of(
    name: str,
    space: Sequence[Dimension],
    *,
    start: Mapping[str, Value],
    seed: int,
    batch: int,
    limit: int,
) -> Method:
    """Return the method of a name.

    Parameters
    ----------
    start
        The values without tuning.
    limit
        Number of candidates.

    Raises
    ------
    UsageRefused
        The method cannot search this space.
    """
    make: Mapping[str, Callable[[], Method]] = {
        "bayesian": lambda: Sampled(space, seed=seed, by_model=True),
        "cma-es": lambda: CmaEs(space, start=start, seed=seed, batch=batch),
        "random": lambda: Sampled(space, seed=seed, by_model=False),
        "grid": lambda: Grid(space, limit=limit),
    }
    return make[name]()
