"""The episodes of an environment: the levels of a run in their order, trial after trial."""

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import gymnasium
import numpy as np

from seamark.sim.engine.experiment import Experiment
from seamark.sim.engine.seeds import SEED_MAX
from seamark.sim.recording import opencv


@dataclass(frozen=True, slots=True)
class Episode:
    """One level of one trial."""

    seed: int
    trial: int
    level: int  # index in the configuration's list
    position: int  # index in the order in which the trial's levels run

    def info(self) -> dict[str, int]:
        """Return what `reset` tells of it."""
        return {"seed": self.seed, "trial": self.trial, "level": self.level}


class Episodes:
    """The levels of the run with one seed: those that `seamark run --seed` has, in its order."""

    def __init__(self, experiment: Experiment, config: Any) -> None:
        if other := opencv.complaint():
            warnings.warn(other, stacklevel=3)
        self._experiment, self._config = experiment, config
        self._seed: int | None = None
        self._trial = self._position = 0
        self._order: tuple[int, ...] = ()

    def begin(
        self, seed: int | None, options: Mapping[str, Any] | None, random: np.random.Generator
    ) -> Episode:
        """Return the episode that a reset begins: the next one, the first one with a seed.

        Parameters
        ----------
        options
            May have a `trial` and a `level` from which to go on.
        random
            Draws the seed of the first run if there is none.

        Raises
        ------
        ValueError
            There is no such trial or level.
        """
        if seed is not None or self._seed is None:
            self._seed = int(random.integers(SEED_MAX + 1)) if seed is None else int(seed)
            self._start(0)
        self._go_to(options or {})
        return self.next()

    def _start(self, trial: int) -> None:
        self._order = self._order_of(self._known_seed(), trial)
        self._trial, self._position = trial, 0

    def _order_of(self, seed: int, trial: int) -> tuple[int, ...]:
        return self._experiment.plan(self._config, seed=seed, trial=trial).order

    def _known_seed(self) -> int:
        if self._seed is None:
            raise gymnasium.error.ResetNeeded("call reset() before step()")
        return self._seed

    def _go_to(self, options: Mapping[str, Any]) -> None:
        if "trial" in options:
            self._start(_check_trial(int(options["trial"])))
        if "level" in options:
            if options["level"] not in self._order:
                last = len(self._order) - 1
                raise ValueError(f"level must be from 0 to {last}, not {options['level']}")
            self._position = self._order.index(options["level"])

    def order_of(self, episode: Episode) -> tuple[int, ...]:
        """Return the levels of an episode's trial in their order, for `resume`.

        Raises
        ------
        ValueError
            The run has no such episode.
        """
        _check_trial(episode.trial)
        order = self._order_of(episode.seed, episode.trial)
        if order[episode.position : episode.position + 1] != (episode.level,):
            raise ValueError(f"the run has no such level: {episode}")
        return order

    def resume(self, episode: Episode, order: tuple[int, ...]) -> None:
        """Go on after an episode that has begun."""
        self._seed, self._trial, self._order = episode.seed, episode.trial, order
        self._position = episode.position + 1

    def next(self) -> Episode:
        """Return the next episode.

        Raises
        ------
        ResetNeeded
            None has begun yet.
        """
        seed = self._known_seed()
        if self._position == len(self._order):
            self._start(self._trial + 1)
        position, self._position = self._position, self._position + 1
        return Episode(seed, self._trial, self._order[position], position)


def _check_trial(trial: int) -> int:
    if not 0 <= trial < 2**31:
        raise ValueError(f"trial must be from 0 to 2147483647, not {trial}")
    return trial
