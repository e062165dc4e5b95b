"""One demonstration: an episode of a benchmark's environment, driven by a built-in controller."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from seamark.sim import registry

if TYPE_CHECKING:
    from seamark.gym.intervention import InterventionEnv

TRIAL = 0  # of its seed: every episode has a seed of its own
FLOAT32, FLOAT64 = "float32", "float64"


@dataclass(frozen=True, slots=True, kw_only=True)
class Task:
    """What is demonstrated, and by whom."""

    benchmark: str
    settings: Mapping[str, Any]  # those that are not the benchmark's own
    expert: str
    reward: str
    dtype: str  # of observations and actions

    def options(self) -> dict[str, Any]:
        """Return the arguments of `gymnasium.make` beside the name."""
        return {"settings": dict(self.settings), "reward": self.reward, "dtype": self.dtype}

    def environment(self) -> InterventionEnv:
        """Return the environment."""
        import gymnasium

        import seamark.gym  # registers it  # noqa: F401

        gym_id = registry.benchmark(self.benchmark).gym_id
        made: Any = gymnasium.make(gym_id, **self.options()).unwrapped
        return made  # type: ignore[no-any-return]


@dataclass(frozen=True, slots=True, kw_only=True)
class Attempt:
    """Which episode is tried."""

    number: int
    seed: int
    level: int  # index in the list of levels


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """What came of an attempt."""

    number: int
    seed: int
    trial: int
    level: int
    current_m_s: float  # of the level, in the mean
    steps: int
    credit: float
    stages: int  # that were reached
    success: bool

    def as_dict(self) -> dict[str, Any]:
        """Return it as plain JSON values."""
        return asdict(self)


@dataclass(slots=True)
class Images:
    """What one camera saw."""

    frames: list[NDArray[np.uint8]] = field(default_factory=list)  # each (height, width), grey
    newest: list[int] = field(default_factory=list)  # for each observation, the index of its frame

    def __iter__(self) -> Iterator[NDArray[np.uint8]]:
        """Yield the image of each observation."""
        return (self.frames[at] for at in self.newest)

    def is_new(self) -> NDArray[np.bool_]:
        """Return for each observation whether its image is not that of the one before, (n + 1,)."""
        return np.diff(np.array(self.newest), prepend=-1) > 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Demonstration:
    """An episode of n steps.

    Attributes
    ----------
    observations : (n + 1, k)
        Packed observations, the last one after the last action.
    actions : (n, m)
        Velocity references [m/s, rad/s], then speeds of the joints [rad/s].
    rewards : (n,)
    terminations, truncations : (n,)
        The last number is whether the episode ended so.
    credit, stages : (n + 1,)
        Of the level so far: its credit, and how many stages were reached.
    images
        Camera -> what it saw.
    """

    outcome: Outcome
    observations: NDArray[Any]
    actions: NDArray[Any]
    rewards: NDArray[np.float64]
    terminations: NDArray[np.bool_]
    truncations: NDArray[np.bool_]
    credit: NDArray[np.float64]
    stages: NDArray[np.int64]
    images: Mapping[str, Images]

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return all numbers by name."""
        names = ("observations", "actions", "rewards", "terminations", "truncations")
        return {name: getattr(self, name) for name in (*names, "credit", "stages")}


def demonstrate(task: Task, attempt: Attempt) -> Demonstration:
    """Return the episode of an attempt; the expert sees exactly the observations that it has."""
    from seamark.sim.benchmarks.intervention.experiment import DONE_CREDIT

    env = task.environment()
    options = {"trial": TRIAL, "level": attempt.level}
    recorder = _Recorder(*env.reset(seed=attempt.seed, options=options))
    expert, over = Expert(task, attempt, recorder.observation), False
    while not over:
        action = np.asarray(expert.action(recorder.observation), dtype=task.dtype)
        observation, reward, terminated, truncated, info = env.step(action)
        recorder.add_step(action, reward, terminated=terminated, truncated=truncated)
        recorder.see(observation, info)
        over = terminated or truncated
    env.close()
    credit = recorder.credit[-1]
    outcome = Outcome(
        number=attempt.number,
        seed=attempt.seed,
        trial=TRIAL,
        level=attempt.level,
        current_m_s=expert.current_m_s,
        steps=len(recorder.actions),
        credit=credit,
        stages=recorder.stages[-1],
        success=credit >= DONE_CREDIT,
    )
    return recorder.demonstration(outcome)


class Expert:
    """A built-in controller, asked from outside of the loop."""

    def __init__(self, task: Task, attempt: Attempt, first: Any) -> None:
        entry = registry.benchmark(task.benchmark)
        config: Any = entry.read(task.settings)
        experiment: Any = entry.load()
        order = experiment.plan(config, seed=attempt.seed, trial=TRIAL).order
        self.current_m_s = float(config.level_values()[attempt.level])
        self._program = experiment.built_in(task.expert, config.for_trial(TRIAL))
        self._program.reset(
            {
                "index": order.index(attempt.level),
                "count": len(order),
                "duration_s": config.level_duration_s,
                "dt": config.control_period_s,
                "t": float(_state_of(first)[0]),
            }
        )

    @property
    def controller(self) -> Any:
        """The controller itself, such as to learn from its phases, too."""
        return self._program.controller

    def action(self, observation: Any) -> tuple[float, ...]:
        """Return what it does."""
        if images := _images_of(observation):
            self._program.show(images)
        command: tuple[float, ...] = self._program.step(_state_of(observation).astype(np.float64))
        return command


class _Recorder:
    """Collects an episode."""

    def __init__(self, observation: Any, info: Mapping[str, Any]) -> None:
        self.observation: Any = None
        self.actions: list[NDArray[Any]] = []
        self.credit: list[float] = []
        self.stages: list[int] = []
        self._states: list[NDArray[Any]] = []
        self._rewards: list[float] = []
        self._ended: list[tuple[bool, bool]] = []
        self._images = {name: Images() for name in _images_of(observation)}
        self.see(observation, info)

    def see(self, observation: Any, info: Mapping[str, Any]) -> None:
        """Add an observation."""
        state = _state_of(observation)
        # the last number is the time of the newest images
        renewed = not self._states or state[-1] != self._states[-1][-1]
        for name, image in _images_of(observation).items():
            seen = self._images[name]
            if renewed:
                seen.frames.append(image)
            seen.newest.append(len(seen.frames) - 1)
        self.observation = observation
        self._states.append(state)
        self.credit.append(float(info["credit"]))
        self.stages.append(int(info["stages"]))

    def add_step(
        self, action: NDArray[Any], reward: float, *, terminated: bool, truncated: bool
    ) -> None:
        """Add an action and what came of it."""
        self.actions.append(action)
        self._rewards.append(reward)
        self._ended.append((terminated, truncated))

    def demonstration(self, outcome: Outcome) -> Demonstration:
        """Return the whole episode."""
        ended = np.array(self._ended)
        return Demonstration(
            outcome=outcome,
            observations=np.array(self._states),
            actions=np.array(self.actions),
            rewards=np.array(self._rewards),
            terminations=ended[:, 0],
            truncations=ended[:, 1],
            credit=np.array(self.credit),
            stages=np.array(self.stages),
            images=self._images,
        )


def _state_of(observation: Any) -> NDArray[Any]:
    from seamark.gym.spaces import STATE

    state: NDArray[Any] = observation[STATE] if isinstance(observation, Mapping) else observation
    return state


def _images_of(observation: Any) -> dict[str, NDArray[np.uint8]]:
    from seamark.gym.spaces import IMAGE, STATE

    if not isinstance(observation, Mapping):
        return {}
    return {key.removeprefix(IMAGE): observation[key] for key in observation if key != STATE}
