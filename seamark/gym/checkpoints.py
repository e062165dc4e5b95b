"""Checkpoints: the state of an environment as a dict of NumPy arrays.

`numpy.savez(file, **state)` writes one and `numpy.load(file)` reads it: there is nothing in it that
would need pickle. What is no array of numbers is JSON, in the array `header`.
"""

import importlib.metadata
import json
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import astuple
from typing import Any, NamedTuple, TypeVar

import gymnasium
import numpy as np
from numpy.typing import NDArray

from seamark.gym.episodes import Episode, Episodes

State = dict[str, NDArray[Any]]
HEADER, ACTIONS, ROW = "header", "actions", "telemetry"
SINGLE, MANY = "one environment", "a vector environment"  # kinds of what has a state
_VERSION = importlib.metadata.version("seamark")
Seen = TypeVar("Seen")
Act = TypeVar("Act")


class CheckpointInvalid(ValueError):
    """What an environment is to go on from is no state of one like it; the text says why."""


class Header(NamedTuple):
    """What a state has beside its arrays."""

    kind: str
    options: Mapping[str, object]  # on which the future depends, by name
    episodes: Sequence[Episode]  # of each vehicle
    random: np.random.Generator


def options_of(benchmark: str, config: Any, **others: object) -> dict[str, object]:
    """Return the options on which the future of an environment depends, as plain JSON values."""
    options = {"benchmark": benchmark} | config.model_dump(mode="json") | others
    plain: dict[str, object] = json.loads(json.dumps(options))
    return plain


def written(header: Header, arrays: Mapping[str, NDArray[Any]]) -> State:
    """Return a state."""
    text = {
        "version": _VERSION,
        "kind": header.kind,
        "options": header.options,
        "episodes": [astuple(episode) for episode in header.episodes],
        "random": header.random.bit_generator.state,
    }
    return {HEADER: np.array(json.dumps(text)), **arrays}


def read(
    state: Mapping[str, Any], kind: str, options: Mapping[str, object]
) -> tuple[Header, State]:
    """Return the header of a state, and its arrays.

    Raises
    ------
    CheckpointInvalid
        It is no state, or that of another kind of environment, version, or with other options.
    """
    if not isinstance(state, Mapping) or HEADER not in state:
        raise CheckpointInvalid("this is no state of an environment: it has no header")
    arrays = {name: np.asarray(state[name]) for name in state}
    try:
        text = json.loads(str(arrays.pop(HEADER)))
        version, of = text["version"], text["kind"]
        others: Mapping[str, object] = dict(text["options"])
    except (ValueError, TypeError, KeyError) as error:
        raise CheckpointInvalid(f"the header of the state cannot be read: {error!r}") from error
    if of != kind:
        raise CheckpointInvalid(f"the state is of {of}, not of {kind}")
    if version != _VERSION:
        raise CheckpointInvalid(f"the state is of Seamark {version}, not {_VERSION}")
    for name in sorted({*others, *options}):
        one, other = others.get(name), options.get(name)
        if one != other:
            raise CheckpointInvalid(
                f"the state is of an environment with {name} {one!r}, not {other!r}"
            )
    try:
        episodes = [_episode(numbers) for numbers in text["episodes"]]
        generator = np.random.Generator(np.random.PCG64())
        generator.bit_generator.state = text["random"]
    except (ValueError, TypeError, KeyError, OverflowError) as error:
        raise CheckpointInvalid(f"the header of the state cannot be read: {error!r}") from error
    return Header(of, others, episodes, generator), arrays


def _episode(numbers: Sequence[int]) -> Episode:
    seed, trial, level, position = numbers
    if not all(type(number) is int and number >= 0 for number in numbers):
        raise ValueError(f"an episode is four whole numbers, not {numbers!r}")
    return Episode(seed, trial, level, position)


class Replayed(gymnasium.Env[Seen, Act]):
    """An environment whose state is its episode and the actions so far.

    So nothing has to be known of its parts, trackers and arms among them; it goes on from a state
    by taking the same actions again.
    """

    _episodes: Episodes
    _options: Mapping[str, object]
    _episode: Episode | None = None
    _actions_taken: list[NDArray[np.float64]]

    @property
    @abstractmethod
    def telemetry(self) -> NDArray[np.float64]:
        """The row of telemetry by which two states are compared."""

    @abstractmethod
    def _begin(self, episode: Episode) -> None:
        """Put the vehicle at the start of an episode."""

    @abstractmethod
    def _take(self, numbers: NDArray[np.float64]) -> Any:
        """Simulate a step with an action that is not normalised; return what `step` does."""

    @abstractmethod
    def _observation(self) -> Seen:
        """Return the present observation."""

    @abstractmethod
    def _truth(self) -> dict[str, Any]:
        """Return the ground truth of the present state, as `info` has it."""

    def _start(self, episode: Episode) -> None:
        """Begin an episode, and forget the actions of the one before."""
        self._episode, self._actions_taken = episode, []
        self._begin(episode)

    def _advance(self, numbers: NDArray[np.float64]) -> Any:
        """Take an action and keep its numbers."""
        result = self._take(numbers)
        self._actions_taken.append(numbers.copy())
        return result

    def get_state(self) -> State:
        """Return all that the future depends on, for `set_state`; see docs/training.md.

        Raises
        ------
        ResetNeeded
            No episode has begun.
        """
        if self._episode is None:
            raise gymnasium.error.ResetNeeded("call reset() before get_state()")
        header = Header(SINGLE, self._options, [self._episode], self.np_random)
        actions = np.array(self._actions_taken, np.float64)
        return written(header, {ACTIONS: actions, ROW: self.telemetry})

    def set_state(self, state: Mapping[str, Any]) -> tuple[Seen, dict[str, Any]]:
        """Go on from a state of `get_state`; return observation and info, as `reset` does.

        It takes the actions of the episode again, which takes as long as they took.

        Raises
        ------
        CheckpointInvalid
            It is no state of such an environment with the same benchmark, settings and action, or
            simulating it again gave other bits.
        """
        header, arrays = read(state, SINGLE, self._options)
        size = self.action_space.shape[0] if self.action_space.shape else 0
        actions = arrays.get(ACTIONS, np.zeros(1))
        if ACTIONS not in arrays or actions.dtype != np.float64:
            raise CheckpointInvalid("the state has no actions")
        if len(actions) and actions.shape != (len(actions), size):
            raise CheckpointInvalid(f"the actions of the state have shape {actions.shape}")
        if len(header.episodes) != 1:
            raise CheckpointInvalid("the state has no episode")
        self.np_random = header.random
        try:
            self._episodes.resume(header.episodes[0])
        except ValueError as error:
            raise CheckpointInvalid(f"the state has no episode: {error}") from error
        self._start(header.episodes[0])
        for numbers in actions:
            self._advance(numbers)
        if not np.array_equal(self.telemetry, arrays.get(ROW, np.zeros(0)), equal_nan=True):
            raise CheckpointInvalid("taking the actions of the state again gave other bits")
        return self._observation(), self._truth()
