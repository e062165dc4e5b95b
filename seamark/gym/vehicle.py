"""A vehicle in closed loop as a Gymnasium environment: one level per episode."""

from abc import abstractmethod
from collections.abc import Mapping
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import DTypeLike, NDArray

from seamark.gym.checkpoints import ONE, Replayed, options_of
from seamark.gym.episodes import Episode, Episodes
from seamark.gym.spaces import (
    IMAGE,
    STATE,
    THRUSTERS,
    VELOCITY,
    Actions,
    observation_space,
    with_images,
)
from seamark.sim import registry
from seamark.sim.benchmarks.in_current import InCurrent
from seamark.sim.control.observation import empty
from seamark.sim.engine.closed_loop import ClosedLoop, StateInvalid
from seamark.sim.engine.delay import STILL
from seamark.sim.engine.program import Command
from seamark.sim.engine.world import World
from seamark.sim.recording.telemetry import (
    ARM_INDEX,
    ARM_JOINTS,
    INDEX,
    STEP_US,
    has_arm,
)
from seamark.sim.settings import own_files

Packed = NDArray[Any]  # float64, or float32 if the environment is made so
Observation = Packed | dict[str, NDArray[Any]]
REFERENCE = slice(INDEX["ref_u"], INDEX["ref_r"] + 1)  # columns that an action decides
JOINT_REFERENCE = slice(ARM_INDEX["joint_ref_0"], ARM_INDEX["joint_ref_0"] + ARM_JOINTS)
TRUE_COLUMNS: dict[str, Any] = {  # name in `info` -> columns of the telemetry
    "pose": slice(INDEX["x"], INDEX["yaw"] + 1),
    "velocity": slice(INDEX["u"], INDEX["r"] + 1),
    "current": slice(INDEX["current_x"], INDEX["current_z"] + 1),
    "distance": INDEX["distance"],
    "tracker_error": INDEX["tracker_error"],
}


def truth_of(row: NDArray[np.float64]) -> dict[str, Any]:
    """Return what `info` has of a row of telemetry, (WIDTH or more,), in new arrays."""
    return {name: row[columns] + 0.0 for name, columns in TRUE_COLUMNS.items()}


class _Held:
    """The program in the loop: returns the action of the present step."""

    def __init__(self) -> None:
        self.command: Command = STILL

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Do nothing: a policy is reset by who owns it."""

    def step(self, values: Packed) -> Command:
        """Return the action."""
        return self.command


class _ThrusterLoop(ClosedLoop):
    """A loop without the velocity controller; commands arrive as late as those of a controller."""

    def __init__(self, world: World, held: _Held, **indices: int) -> None:
        super().__init__(world, held, **indices)
        self.thrust_commands = np.zeros(len(world.plant.vehicle.thrusters))
        late = world.conditions.command_delay_steps
        self._pending = [np.zeros_like(self.thrust_commands)] * late

    def _steers(self) -> None:
        """Return None: the commands come from outside."""

    def commands(self, reference: Command) -> NDArray[np.float64]:
        """Return the thrusters' commands that arrive now."""
        self._pending.append(self.thrust_commands.copy())
        return self._pending.pop(0)


class VehicleEnv(Replayed[Observation, Packed]):
    """One vehicle above its target; what a step earns is for subclasses.

    An episode is one level, truncated at its end. `reset(seed=N)` begins the run with seed N, the
    same as `seamark run --seed N`; each further `reset()` is the next level of that run.
    `reset(options={"trial": 1, "level": 0})` goes on from there. The docs have all else.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 20}  # noqa: RUF012  # as Gymnasium's

    def __init__(
        self,
        *,
        benchmark: str,
        settings: Mapping[str, object] | None = None,
        action: str = VELOCITY,
        render_mode: str | None = None,
        dtype: DTypeLike = np.float64,
        normalise_actions: bool = False,
    ) -> None:
        """Set up the environment.

        Parameters
        ----------
        settings
            Of the benchmark, such as `{"tracker": "truth", "vehicle": "girona500"}`; see
            `seamark benchmarks NAME`. The vehicle may be a file of your own, "my_rov.toml".
        action
            "velocity": what a controller returns; "thrusters": commands of the thrusters.
        dtype
            Of observations and actions: float64 as in an uploaded controller, or float32. The
            simulation computes in float64.
        normalise_actions
            Whether all actions are from -1 to 1, in shares of the limits of the vehicle.

        Raises
        ------
        ConfigurationInvalid, VehicleInvalid
            A setting, or the file of a vehicle, is not valid.
        ValueError
            There is no such action, render mode or type of numbers.
        """
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise ValueError(f"render_mode must be rgb_array, not {render_mode!r}")
        self.render_mode = render_mode
        entry = registry.benchmark(benchmark)
        config: Any = entry.read(own_files.resolved(settings or {}))
        self._config = config
        experiment = entry.load()
        self._experiment: InCurrent[Any] = experiment  # type: ignore[assignment]
        space = observation_space(config, dtype)
        self._observed, self._dtype = space.shape, space.dtype
        self.observation_space: gymnasium.Space[Any] = with_images(space, config)
        self._actions = Actions(config, action, normalised=normalise_actions, dtype=dtype)
        self.action_space: gymnasium.Space[Any] = self._actions.space
        self.metadata = self.metadata | {"render_fps": round(1.0 / config.control_period_s)}
        self._options = options_of(benchmark, config, ONE, action=action)
        self._by_thrusters = action == THRUSTERS
        arm = config.chosen_arm()
        joints = len(arm.motors()) if arm else 0
        self._vehicle_actions = self.action_space.shape[0] - joints  # those of the joints follow
        self._episodes = Episodes(experiment, config)
        self._loop: ClosedLoop | None = None
        self._held = _Held()
        self._step = 0

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin the next level; with a seed, the first one of the run with that seed."""
        super().reset(seed=seed)
        self._start(episode := self._episodes.begin(seed, options, self.np_random))
        return self._observation(), episode.info() | self._truth()

    def _start(self, episode: Episode) -> None:
        super()._start(episode)
        self._sense()

    def _begin(self, episode: Episode) -> None:
        self.close()
        trial, level = episode.trial, episode.level
        self._world = self._experiment.world(
            self._config, seed=episode.seed, trial=trial, level=level
        )
        indices = {"trial": trial, "level": level, "position": episode.position}
        self._loop = (
            _ThrusterLoop(self._world, self._held, **indices)
            if self._by_thrusters
            else ClosedLoop(self._world, self._held, **indices)
        )
        self._steps = self._world.config.control_steps_per_level
        self._first_frame = episode.position * self._steps
        self._step, self._row = 0, np.zeros(self._running.width())
        # Numbers of the observation that follow the thrusts, which a vehicle may have fewer of.
        thrusters = len(self._world.plant.vehicle.thrusters)
        self._after_thrusts = len(self._running.observation) - len(empty(thrusters))

    def _sense(self) -> None:
        self._running.sense(self._step, self._row)

    @abstractmethod
    def _reward(self) -> float:
        """Return what the step earns that ends in the present state."""

    @property
    def _running(self) -> ClosedLoop:
        if self._loop is None:
            raise gymnasium.error.ResetNeeded("call reset() before step() and render()")
        return self._loop

    def step(self, action: Packed) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Simulate one control period.

        An episode is terminated only if the simulation diverges, such as by an action that is not a
        number.
        """
        commands = self._actions.commands(action)
        if commands.shape != self.action_space.shape:
            raise ValueError(f"an action has shape {self.action_space.shape}, not {commands.shape}")
        result: tuple[Observation, float, bool, bool, dict[str, Any]] = self._advance(commands)
        return result

    def _take(self, numbers: Packed) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        loop = self._running
        self._hold(numbers)
        try:
            loop.act(self._step, self._row)
            self._step += 1
            self._sense()
        except StateInvalid:
            return self._observation(), 0.0, True, False, self._truth()
        over = self._step >= self._steps
        return self._observation(), self._reward(), False, over, self._truth()

    def _hold(self, action: Packed) -> None:
        """Take an action for the next control step."""
        joints = tuple(action[self._vehicle_actions :].tolist())
        if isinstance(self._loop, _ThrusterLoop):
            self._loop.thrust_commands[:] = action[: len(self._loop.thrust_commands)]
            self._held.command = (*STILL, *joints)
        else:
            self._held.command = (*action[: self._vehicle_actions].tolist(), *joints)

    def _observation(self) -> Observation:
        values = self._running.observation
        observation = np.zeros(self._observed, self._dtype)
        vehicle = len(values) - self._after_thrusts
        observation[:vehicle] = values[:vehicle]
        observation[len(observation) - self._after_thrusts :] = values[vehicle:]
        if self._running.images is None:
            return observation
        newest = self._running.images.newest.items()
        return {STATE: observation} | {IMAGE + name: image.copy() for name, image in newest}

    def _truth(self) -> dict[str, Any]:
        return truth_of(self._row)

    @property
    def telemetry(self) -> Packed:
        """The row of telemetry of the present state, without what follows from the next action."""
        row = self._row.copy()
        row[REFERENCE] = 0.0
        row[STEP_US] = 0.0
        if has_arm(len(row)):
            row[JOINT_REFERENCE] = 0.0
        return row

    def render(self) -> NDArray[np.uint8] | None:
        """Return what the camera sees, (H, W, 3) red, green, blue."""
        if self.render_mode is None:
            return None
        motion = self._running.motion()
        image = self._world.camera.colour(motion, self._first_frame + self._step)
        return np.ascontiguousarray(image[..., ::-1])

    def close(self) -> None:
        """Release what the present level holds."""
        if self._loop is not None:
            self._loop.close()
            self._loop = None
