"""Checkpoints: the state of an environment as a dict of NumPy arrays.

`numpy.savez(file, **state)` writes one and `numpy.load(file)` reads it: there is nothing in it that
would need pickle. What is no array of numbers is JSON, in the array `header`.
"""

import importlib.metadata
import json
import reprlib
import zipfile
import zlib
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
ONE, MANY = "one", "many"  # vehicles of an environment
_VERSION = importlib.metadata.version("seamark")
_UNREADABLE = (ValueError, TypeError, KeyError, OverflowError, RecursionError)
_CANNOT = (ValueError, OSError, EOFError, zipfile.BadZipFile, zlib.error)  # of a broken file
Seen = TypeVar("Seen")
Act = TypeVar("Act")


class CheckpointInvalid(ValueError):
    """What an environment is to go on from is no state of one like it; the text says why."""


class Header(NamedTuple):
    """What a state has beside its arrays."""

    episodes: Sequence[Episode]  # of each vehicle
    random: np.random.Generator


def options_of(benchmark: str, config: Any, vehicles: str, **others: object) -> dict[str, object]:
    """Return what must be the same in two environments for one to go on from the other's state."""
    first = {"Seamark": _VERSION, "benchmark": benchmark, "vehicles": vehicles}
    options = first | config.model_dump(mode="json") | others
    plain: dict[str, object] = json.loads(json.dumps(options))
    return plain


def written(
    header: Header, options: Mapping[str, object], arrays: Mapping[str, NDArray[Any]]
) -> State:
    """Return a state."""
    text = {
        "options": options,
        "episodes": [astuple(episode) for episode in header.episodes],
        "random": header.random.bit_generator.state,
    }
    return {HEADER: np.array(json.dumps(text)), **arrays}


def read(state: Mapping[str, Any], options: Mapping[str, object]) -> tuple[Header, State]:
    """Return the header of a state, and its arrays.

    Raises
    ------
    CheckpointInvalid
        It is no state, or that of an environment with other options.
    """
    if not isinstance(state, Mapping) or HEADER not in state:
        raise CheckpointInvalid("this is no state of an environment: it has no header")
    try:
        arrays = {name: np.asarray(state[name]) for name in state}
    except _CANNOT as error:
        raise CheckpointInvalid(f"the state cannot be read: {error}") from error
    try:
        text = json.loads(str(arrays.pop(HEADER)))
        others: Mapping[str, object] = dict(text["options"])
    except _UNREADABLE as error:
        raise CheckpointInvalid(f"the header of the state cannot be read: {error!r}") from error
    for name in (*options, *(others.keys() - options.keys())):
        one, other = others.get(name), options.get(name)
        if one != other:
            told = f"{name} {reprlib.repr(one)}, not {reprlib.repr(other)}"
            raise CheckpointInvalid(f"the state is of an environment with {told}")
    try:
        episodes = [_episode(numbers) for numbers in text["episodes"]]
        generator = np.random.Generator(np.random.PCG64())
        generator.bit_generator.state = text["random"]
    except _UNREADABLE as error:
        raise CheckpointInvalid(f"the header of the state cannot be read: {error!r}") from error
    return Header(episodes, generator), arrays


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
        """Take an action and keep its numbers: nobody may change the array afterwards."""
        self._actions_taken.append(numbers)
        return self._take(numbers)

    def get_state(self) -> State:
        """Return all that the future depends on, for `set_state`; see docs/training.md.

        Raises
        ------
        ResetNeeded
            No episode has begun.
        """
        if self._episode is None:
            raise gymnasium.error.ResetNeeded("call reset() before get_state()")
        header = Header([self._episode], self.np_random)
        actions = np.reshape(self._actions_taken, (-1, self._action_numbers()))
        return written(header, self._options, {ACTIONS: actions, ROW: self.telemetry})

    def set_state(self, state: Mapping[str, Any]) -> tuple[Seen, dict[str, Any]]:
        """Go on from a state of `get_state`; return observation and info, as `reset` does.

        It takes the actions of the episode again, which takes as long as they took.

        Raises
        ------
        CheckpointInvalid
            It is no state of such an environment with the same benchmark, settings and action, or
            simulating it again gave other bits: then the environment needs a reset.
        """
        header, arrays = read(state, self._options)
        actions, row = arrays.get(ACTIONS, np.zeros(0)), arrays.get(ROW, np.zeros(0))
        if actions.dtype != np.float64 or actions.shape != (len(actions), self._action_numbers()):
            raise CheckpointInvalid(
                f"actions of type {actions.dtype} and shape {actions.shape} do not fit"
            )
        if len(header.episodes) != 1:
            raise CheckpointInvalid(f"the state has {len(header.episodes)} episodes, not one")
        (episode,) = header.episodes
        try:
            order = self._episodes.order_of(episode)
        except ValueError as error:
            raise CheckpointInvalid(f"the state does not fit: {error}") from error
        self._episodes.resume(episode, order)
        self._start(episode)
        over = False
        for numbers in actions:
            if over:
                raise CheckpointInvalid("the state has actions after the end of its level")
            _, _, terminated, truncated, _ = self._advance(numbers.copy())
            over = terminated or truncated
        if not np.array_equal(self.telemetry, row, equal_nan=True):
            raise CheckpointInvalid("taking the actions of the state again gave other bits")
        self.np_random = header.random
        return self._observation(), episode.info() | self._truth()

    def _action_numbers(self) -> int:
        (size,) = self.action_space.shape or (0,)
        return size
