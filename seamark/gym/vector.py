"""Station keeping with many vehicles at once, as a Gymnasium vector environment."""

from collections.abc import Mapping, Sequence
from itertools import accumulate, pairwise
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import DTypeLike, NDArray

from seamark.gym.checkpoints import (
    MANY,
    CheckpointInvalid,
    Header,
    State,
    options_of,
    read,
    written,
)
from seamark.gym.episodes import Episode, Episodes
from seamark.gym.images import (
    CORNERS,
    DEPTH,
    GREY,
    IMAGE,
    IMAGE_SIZE,
    SEGMENTATION,
    ObservationParts,
)
from seamark.gym.spaces import STATE, THRUSTERS, VELOCITY, Actions, observation_space
from seamark.gym.vehicle import REFERENCE, TRUE_COLUMNS
from seamark.sim import registry
from seamark.sim.benchmarks.station_keeping.experiment import StationKeeping
from seamark.sim.engine.tracker_in_loop import draw_start_error
from seamark.sim.fleet.fleet import Fleet
from seamark.sim.fleet.memory import Memory, MemoryInvalid
from seamark.sim.numerics.arrays import Flags
from seamark.sim.numerics.random_streams import streams
from seamark.sim.registry import TRUTH
from seamark.sim.settings import own_files

Array = NDArray[Any]  # float64, or float32 if the environment is made so
Observation = Any  # an array; of several parts, a dict of them
Info = dict[str, Any]
_UNPLACED = "call reset() first, for all vehicles"
_OVER = "over"  # of a state: whether a vehicle's episode is over
_COLUMNS = np.r_[tuple(TRUE_COLUMNS.values())]  # of telemetry, one after the other


def _places() -> dict[str, slice | int]:
    """Return where in `_COLUMNS` each truth is."""
    ends = accumulate((np.r_[columns].size for columns in TRUE_COLUMNS.values()), initial=0)
    return {
        name: slice(begin, end) if isinstance(columns, slice) else begin
        for (name, columns), (begin, end) in zip(TRUE_COLUMNS.items(), pairwise(ends), strict=True)
    }


_PLACES = _places()


class StationKeepingVectorEnv(VectorEnv[Observation, Array, Any]):
    """Vehicles that do not meet, each as in `StationKeepingEnv`, with the same bits.

    `reset(seed=N)` gives the vehicles the seeds N, N + 1, and so on. One compiled call simulates a
    control step of all of them, tracks their targets and draws their images, on as many threads as
    there are cores. With the tracker "truth" no image is rendered for it; trackers other
    than the template tracker get theirs one after the other.
    """

    def __init__(  # noqa: PLR0913  # one argument per option
        self,
        *,
        num_envs: int,
        benchmark: str,
        settings: Mapping[str, object] | None = None,
        action: str = VELOCITY,
        render_mode: str | None = None,
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
        threads: int | None = None,
        dtype: DTypeLike = np.float64,
        normalise_actions: bool = False,
        observation: str = STATE,
        image_size: tuple[int, int] = IMAGE_SIZE,
        channels: str = GREY,
    ) -> None:
        """Set up the environment.

        Parameters
        ----------
        settings, action, dtype, normalise_actions, observation, image_size, channels
            As of `StationKeepingEnv`.
        autoreset_mode
            "NextStep", "SameStep" or "Disabled"; see `step`.
        threads
            At most so many; None: one per core. Their number changes no bit of a result.

        Raises
        ------
        ConfigurationInvalid, VehicleInvalid
            A setting, or the file of a vehicle, is not valid.
        ValueError
            There is no such action, observation, render mode or autoreset mode, or a setting
            needs the single environment.
        """
        if num_envs < 1:
            raise ValueError(f"num_envs must be at least 1, not {num_envs}")
        if render_mode not in (None, "rgb_array"):
            raise ValueError(f"render_mode must be rgb_array, not {render_mode!r}")
        entry = registry.benchmark(benchmark)
        config: Any = entry.read(own_files.resolved(settings or {}))
        self._config, self.num_envs, self.render_mode = config, num_envs, render_mode
        self._experiment: StationKeeping[Any] = entry.load()  # type: ignore[assignment]
        self.autoreset_mode = AutoresetMode(autoreset_mode)
        self.metadata = {
            "render_modes": ["rgb_array"],
            "render_fps": round(1.0 / config.control_period_s),
            "autoreset_mode": self.autoreset_mode,
        }
        packed = observation_space(config, dtype)
        self._dtype = packed.dtype
        self._shown = ObservationParts(config, observation, image_size, channels)
        self.single_observation_space = self._shown.space(packed)
        self._actions = Actions(config, action, normalised=normalise_actions, dtype=dtype)
        self.single_action_space = self._actions.space
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._fleet = Fleet(
            config,
            num_envs,
            tool_m=self._experiment.tool_m(config),
            by_thrusters=action == THRUSTERS,
            threads=threads,
            images=self._shown.images,
        )
        self._with_camera = config.tracker != TRUTH or render_mode is not None
        self._episodes = [Episodes(self._experiment, config) for _ in range(num_envs)]
        self._options = options_of(benchmark, config, MANY, action=action)
        images = self._fleet.images if self._shown.images is not None else None
        self._memory = Memory(self._fleet, config, images)
        self._begun: list[Episode | None] = [None] * num_envs
        self._placed = False
        self._over = np.zeros(num_envs, np.bool_)

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Observation, Info]:
        """Begin the next level of each vehicle; with seeds, the first of the run with that seed.

        `options` may have `trial` and `level`, and `reset_mask`, (n,): which vehicles are reset.
        """
        super().reset(seed=seed if isinstance(seed, int) else None)
        choice = dict(options or {})
        chosen = choice.pop("reset_mask", np.ones(self.num_envs, np.bool_))
        if not isinstance(chosen, np.ndarray) or chosen.shape != self._over.shape:
            raise ValueError(f"reset_mask must be an array of shape {self._over.shape}")
        if isinstance(seed, int):
            seed = [seed + i for i in range(self.num_envs)]
        seeds = [None] * self.num_envs if seed is None else list(seed)
        if len(seeds) != self.num_envs:
            raise ValueError(f"there must be {self.num_envs} seeds, not {len(seeds)}")
        begun = {
            i: self._episodes[i].begin(seeds[i], choice, self.np_random)
            for i in np.flatnonzero(chosen).tolist()
        }
        return self._begin(chosen, begun)

    def _begin_next(self, chosen: Flags) -> tuple[Observation, Info]:
        """Put the chosen vehicles at the start of their next levels."""
        return self._begin(
            chosen, {i: self._episodes[i].next() for i in np.flatnonzero(chosen).tolist()}
        )

    def _begin(self, chosen: Flags, begun: Mapping[int, Episode]) -> tuple[Observation, Info]:
        info: Info = {}
        for i, episode in begun.items():
            self._place(i, episode)
            self._begun[i] = episode
            info = self._add_info(info, episode.info(), i)
        self._placed = all(self._begun)
        self._fleet.begin(chosen)
        self._over[chosen] = False
        return self._observations(), info | self._truth(chosen)

    def _place(self, i: int, episode: Episode) -> None:
        config, place = self._config, {"trial": episode.trial, "level": episode.level}
        make = self._experiment.world if self._with_camera else self._experiment.craft
        error = np.zeros(8)
        if config.start_error_px:
            random = streams(episode.seed, episode.trial, episode.level)
            error = draw_start_error(config.start_error_px, random).reshape(8)
        camera = None
        if images := self._shown.images:
            optics = images.optics
            camera = self._experiment.camera(config, seed=episode.seed, optics=optics, **place)
        self._fleet.place(
            i,
            make(config, seed=episode.seed, **place),
            start_s=episode.position * config.level_duration_s,
            trial_level=(episode.trial, episode.level),
            start_error=error,
            camera=camera,
        )

    def step(self, actions: Array) -> tuple[Observation, Array, Flags, Flags, Info]:
        """Simulate one control period of every vehicle.

        A vehicle whose episode is over begins its next level as `autoreset_mode` says: at the next
        step, whose action it ignores; at once, `info["final_obs"]` and `info["final_info"]` then
        have how the old one ended; or not until it is reset.
        """
        values = np.ascontiguousarray(self._actions.commands(actions))
        if values.shape != self.action_space.shape:
            raise ValueError(f"actions have shape {self.action_space.shape}, not {values.shape}")
        if not self._placed:
            raise gymnasium.error.ResetNeeded(_UNPLACED)
        over = self._over.copy()
        if self.autoreset_mode is AutoresetMode.DISABLED and over.any():
            raise gymnasium.error.ResetNeeded("reset the vehicles whose episodes are over")
        outputs, progress = self._fleet.tables.outputs, self._fleet.tables.progress
        self._fleet.step(~over, values)
        terminated = outputs.diverged & ~over
        truncated = ~terminated & ~over & (progress.step >= self._fleet.steps_per_level)
        rewards = np.where(terminated | over, 0.0, outputs.reward)
        self._over = terminated | truncated
        info = self._truth(~over)
        if over.any():
            _, begun = self._begin_next(over)
            info = begun | self._truth(np.ones_like(over))
        elif self.autoreset_mode is AutoresetMode.SAME_STEP and self._over.any():
            info = self._begin_at_once(info)
        return self._observations(), rewards, terminated, truncated, info

    def _begin_at_once(self, ended: Info) -> Info:
        """Reset the vehicles whose episodes are over, and keep how they ended."""
        over = self._over.copy()
        last, final = self._observations(), np.full(self.num_envs, None, dtype=object)
        for i in np.flatnonzero(over).tolist():
            final[i] = {key: last[key][i] for key in last} if isinstance(last, dict) else last[i]
        mask = {name: over.copy() for name in ended if name.startswith("_")}
        _, begun = self._begin_next(over)
        return (
            begun
            | self._truth(np.ones_like(over))
            | {"final_obs": final, "_final_obs": over.copy()}
            | {"final_info": ended | mask, "_final_info": over.copy()}
        )

    def get_state(self) -> State:
        """Return all that the future depends on, for `set_state`; see docs/training.md.

        The first index of its arrays is the vehicle.

        Raises
        ------
        ResetNeeded
            A vehicle has never begun.
        CheckpointInvalid
            The trackers, or the engine of contacts, keep what nobody can copy.
        """
        header = Header(self._episodes_begun(), self.np_random)
        try:
            kept = self._memory.save()
        except MemoryInvalid as error:
            raise CheckpointInvalid(f"there is no state: {error}") from error
        return written(header, self._options, {_OVER: self._over.copy(), **kept})

    def set_state(
        self, state: Mapping[str, Any], *, source: Sequence[int] | None = None
    ) -> tuple[Observation, Info]:
        """Go on from a state of `get_state`; return observations and info, as `reset` does.

        Parameters
        ----------
        source : (n,)
            The vehicle of the state that each vehicle becomes; by default the one with its number.
            The state may then have another number of vehicles.

        Raises
        ------
        CheckpointInvalid
            It is no state of such an environment with the same benchmark, settings, action and
            images, or has no such vehicles.
        """
        header, kept = read(state, self._options)
        count = len(header.episodes)
        chosen = np.arange(count) if source is None else np.array(source, np.int64)
        if chosen.shape != (self.num_envs,) or not set(chosen.tolist()) <= set(range(count)):
            raise CheckpointInvalid(f"source needs {self.num_envs} numbers of {count} vehicles")
        over = kept.get(_OVER, np.zeros(0))
        if over.dtype != np.bool_ or over.shape != (count,):
            raise CheckpointInvalid("it is not known which vehicles are at the end of their levels")
        begun = {i: header.episodes[k] for i, k in enumerate(chosen.tolist())}
        new = np.array([begun[i] != self._begun[i] for i in begun])
        placed = np.flatnonzero(new).tolist()
        try:
            self._memory.check(kept, count, going=~over)
            orders = {i: self._episodes[i].order_of(begun[i]) for i in placed}
        except ValueError as error:
            raise CheckpointInvalid(f"the state does not fit: {error}") from error
        for i, order in orders.items():
            self._episodes[i].resume(begun[i], order)
        if placed:
            self._begin(new, {i: begun[i] for i in placed})
        info: Info = {}
        for i, episode in begun.items():
            info = self._add_info(info, episode.info(), i)
        self._memory.restore(kept, chosen)
        self._over = over[chosen]
        self.np_random = header.random
        return self._observations(), info | self._truth(np.ones_like(self._over))

    def _episodes_begun(self) -> list[Episode]:
        begun = [episode for episode in self._begun if episode is not None]
        if len(begun) < self.num_envs:
            raise gymnasium.error.ResetNeeded(_UNPLACED)
        return begun

    def _observations(self) -> Observation:
        parts: dict[str, Array] = {}
        if STATE in self._shown.names:
            parts[STATE] = self._fleet.tables.outputs.observation.astype(self._dtype)
        if CORNERS in self._shown.names:
            parts[CORNERS] = self._fleet.seen_corners().astype(self._dtype)
        if self._shown.images is not None:
            images = self._fleet.images
            if IMAGE in self._shown.names:
                parts[IMAGE] = images.copy()
            if images.surveys is not None:
                parts[DEPTH] = images.surveys.depth[..., None].copy()
                parts[SEGMENTATION] = images.surveys.labels[..., None].copy()
        return self._shown.of(parts)

    def _truth(self, known: Flags) -> Info:
        """Return the truth of the vehicles as `info` has it, for those in the mask."""
        values = self._fleet.telemetry(_COLUMNS)
        info: Info = {name: values[:, place] for name, place in _PLACES.items()}
        return info | {f"_{name}": known.copy() for name in _PLACES}

    @property
    def telemetry(self) -> Array:
        """The rows of telemetry of the present states, (n, columns), as of the environment."""
        rows = self._fleet.tables.outputs.rows.copy()
        rows[:, REFERENCE] = 0.0
        return rows

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """Return what the cameras see, each (H, W, 3) red, green, blue."""
        if self.render_mode is None:
            return None
        pictures = (self._fleet.picture(i) for i in range(self.num_envs))
        return tuple(np.ascontiguousarray(picture[..., ::-1]) for picture in pictures)

    def close_extras(self, **kwargs: Any) -> None:
        """Release what the vehicles hold."""
        self._fleet.close()
