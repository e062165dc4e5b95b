"""The vector environment in the form that Stable-Baselines3 trains with.

Importing this needs neither Stable-Baselines3 nor PyTorch; where Stable-Baselines3 is installed,
`SeamarkVecEnv` is one of its `VecEnv`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

import seamark.gym  # noqa: F401  # registers the environments
from seamark.gym.checkpoints import State

if TYPE_CHECKING:
    _VecEnv: Any = object
else:
    try:
        from stable_baselines3.common.vec_env import VecEnv as _VecEnv
    except ImportError:
        _VecEnv = object

Array = NDArray[Any]
Observations = Any  # an array; of several parts, a dict of them
Indices = int | Iterable[int] | None
Options = dict[str, Any]
_SHARED = "the vehicles are rows of arrays, so they have no {what} of their own"


def _many(name: str, num_envs: int, **options: Any) -> gymnasium.vector.VectorEnv[Any, Any, Any]:
    """Return the vector environment; where there is none, one with a process for each vehicle."""
    mode = AutoresetMode.SAME_STEP
    if gymnasium.spec(name).vector_entry_point is not None:
        return gymnasium.make_vec(name, num_envs=num_envs, autoreset_mode=mode, **options)
    return gymnasium.make_vec(
        name,
        num_envs=num_envs,
        vectorization_mode="async",
        vector_kwargs={"autoreset_mode": mode},
        **options,
    )


class SeamarkVecEnv(_VecEnv):  # type: ignore[misc]  # without Stable-Baselines3 it is a plain class
    """Vehicles, in float32 and with actions from -1 to 1.

        model = PPO("MlpPolicy", SeamarkVecEnv("seamark/StationKeeping-v3", num_envs=64))

    A vehicle whose level is over begins the next one at once; its info then has
    `terminal_observation` and `TimeLimit.truncated`, as in every `VecEnv`.
    """

    def __init__(
        self,
        name: str = "seamark/StationKeeping-v3",
        *,
        num_envs: int,
        settings: Mapping[str, object] | None = None,
        seed: int | None = None,
        **options: Any,
    ) -> None:
        """Set up the vehicles.

        Parameters
        ----------
        name
            Of an environment of station keeping, or of one with an arm: then each vehicle has a
            process.
        settings
            Of the benchmark; `{"tracker": "truth"}` renders no images.
        seed
            The first reset begins with the runs of the seeds `seed`, `seed + 1`, and so on.
        options
            Further parameters of the environment, such as `threads`, or another `dtype`.
        """
        chosen: dict[str, Any] = {"dtype": np.float32, "normalise_actions": True} | options
        self._env: Any = _many(name, num_envs, settings=settings, **chosen)
        self._actions: Array = np.zeros(0)  # until the first step
        self.num_envs, self.render_mode = num_envs, None
        self.observation_space = self._env.single_observation_space
        self.action_space = self._env.single_action_space
        self.reset_infos: list[dict[str, Any]] = [{} for _ in range(num_envs)]
        if _VecEnv is not object:
            super().__init__(num_envs, self.observation_space, self.action_space)
        self._seed = seed
        self.set_options()

    def seed(self, seed: int | None = None) -> Sequence[int | None]:
        """Take the seed of the next reset; return that of each vehicle."""
        self._seed = seed
        return [None if seed is None else seed + i for i in range(self.num_envs)]

    def set_options(self, options: Options | list[Options] | None = None) -> None:
        """Take the options of the next reset, such as a trial; a list has those of each vehicle."""
        self._options: list[Options]
        self._options = options if isinstance(options, list) else [options or {}] * self.num_envs

    def reset(self) -> Observations:
        """Begin the next level of each vehicle; after a seed, the first one of its run."""
        observations: Observations
        observations, _ = self._env.reset(seed=self._seed)
        every = [each for k, each in enumerate(self._options) if each not in self._options[:k]]
        for options in filter(None, every):
            chosen = {"reset_mask": np.array([each == options for each in self._options])}
            observations, _ = self._env.reset(options=options | chosen)
        self._seed = None
        self.set_options()
        return observations

    def step(self, actions: Array) -> tuple[Observations, Array, Array, list[dict[str, Any]]]:
        """Simulate a control step of all vehicles with their actions, (n, k)."""
        self.step_async(actions)
        return self.step_wait()

    def step_async(self, actions: Array) -> None:
        """Take the actions of the next step."""
        self._actions = actions

    def step_wait(self) -> tuple[Observations, Array, Array, list[dict[str, Any]]]:
        """Return observations, rewards, whether a level is over, and infos."""
        observations, rewards, terminated, truncated, info = self._env.step(self._actions)
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        over = terminated | truncated
        for i in np.flatnonzero(over).tolist():
            infos[i]["terminal_observation"] = info["final_obs"][i]
            infos[i]["TimeLimit.truncated"] = bool(truncated[i])
        return observations, rewards.astype(np.float32), over, infos

    def get_state(self) -> State:
        """Return all that the future depends on, for `set_state`; see docs/training.md.

        Raises
        ------
        NotImplementedError
            Each vehicle has a process of its own.
        """
        state: State = self._in_one_process().get_state()
        return state

    def set_state(
        self, state: Mapping[str, Any], *, source: Sequence[int] | None = None
    ) -> Observations:
        """Go on from a state; return observations, as `reset` does.

        Parameters and errors are those of the vector environment and of `get_state`.
        """
        observations: Observations
        observations, _ = self._in_one_process().set_state(state, source=source)
        self._seed = None
        return observations

    def _in_one_process(self) -> Any:
        if not hasattr(self._env, "get_state"):
            raise NotImplementedError("vehicles with a process each have no state together")
        return self._env

    def close(self) -> None:
        """Release the vehicles."""
        self._env.close()

    def get_attr(self, attr_name: str, indices: Indices = None) -> list[Any]:
        """Return an attribute, which is the same for all vehicles."""
        return [getattr(self._env, attr_name, None)] * len(self._chosen(indices))

    def set_attr(self, attr_name: str, value: Any, indices: Indices = None) -> None:
        """Refuse: the vehicles have no attributes of their own."""
        raise NotImplementedError(_SHARED.format(what="attributes"))

    def env_method(
        self, method_name: str, *args: Any, indices: Indices = None, **kwargs: Any
    ) -> Any:
        """Refuse: the vehicles have no methods of their own."""
        raise NotImplementedError(_SHARED.format(what="methods"))

    def env_is_wrapped(self, wrapper_class: Any, indices: Indices = None) -> list[bool]:
        """Return that no vehicle has a wrapper of its own."""
        return [False] * len(self._chosen(indices))

    def _chosen(self, indices: Indices) -> list[int]:
        if indices is None:
            return list(range(self.num_envs))
        return [indices] if isinstance(indices, int) else list(indices)
