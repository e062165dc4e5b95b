"""The episodes of an environment: the levels of a run in their order, trial after trial."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from seamark.sim.engine.experiment import Experiment


@dataclass(frozen=True, slots=True)
class Episode:
    """One level of one trial."""

    seed: int
    trial: int
    level: int  # index in the configuration's list
    position: int  # place in the order in which the trial's levels run

    def info(self) -> dict[str, int]:
        """Return what `reset` tells of it."""
        return {"seed": self.seed, "trial": self.trial, "level": self.level}


class Episodes:
    """The levels of the run with one seed: those that `seamark run --seed` has, in its order."""

    def __init__(self, experiment: Experiment, config: Any, seed: int) -> None:
        self._experiment, self._config, self._seed = experiment, config, seed
        self._trial = self._position = 0
        self._order = self._planned()

    def _planned(self) -> tuple[int, ...]:
        return self._experiment.plan(self._config, seed=self._seed, trial=self._trial).order

    def go_to(self, options: Mapping[str, Any]) -> None:
        """Go on from the `trial` and the `level` of the options, if there are any.

        Raises
        ------
        ValueError
            There is no such trial or level.
        """
        if "trial" in options:
            if not 0 <= int(options["trial"]) < 2**31:
                raise ValueError(f"trial must be from 0 to 2147483647, not {options['trial']}")
            self._trial, self._position = int(options["trial"]), 0
            self._order = self._planned()
        if "level" in options:
            if options["level"] not in self._order:
                last = len(self._order) - 1
                raise ValueError(f"level must be from 0 to {last}, not {options['level']}")
            self._position = self._order.index(options["level"])

    def next(self) -> Episode:
        """Return the next episode."""
        if self._position == len(self._order):
            self._trial, self._position = self._trial + 1, 0
            self._order = self._planned()
        position, self._position = self._position, self._position + 1
        return Episode(self._seed, self._trial, self._order[position], position)
