"""Visual tracking as a Gymnasium environment: find the target in one image after the other."""

from collections.abc import Mapping
from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box, Dict, Discrete
from numpy.typing import NDArray

from seamark.gym.checkpoints import ONE, Replayed, options_of
from seamark.gym.episodes import Episode, Episodes
from seamark.sim import registry
from seamark.sim.engine.open_loop import OpenLoop
from seamark.sim.metrics.tracking import FAR_PX
from seamark.sim.recording.telemetry import INDEX, STEP_US, WIDTH
from seamark.sim.settings import own_files
from seamark.sim.trackers import Corners, Track, Window

Observation = dict[str, Any]
CORNERS = 8  # numbers of an action that are corners; the last one tells whether there is a target
_CORNER_ERROR, _OK = INDEX["tracker_error"], INDEX["tracker_ok"]


class _Held:
    """The tracker in the loop: keeps what it is started with, and answers with the action."""

    def __init__(self) -> None:
        self.image: NDArray[np.uint8] = np.zeros((0, 0), np.uint8)
        self.corners: Corners = np.zeros((4, 2))
        self.answer = Track(self.corners, False, 0.0, 0)

    def start(self, image: NDArray[np.uint8], corners: Corners) -> None:
        """Keep the image from which a tracker learns the target."""
        self.image, self.corners = image.copy(), corners.copy()

    def window(self) -> Window:
        """Return an empty window: the environment renders the image beforehand."""
        return 0, 0, 0, 0

    def update(self, image: NDArray[np.uint8]) -> Track:
        """Return the action."""
        return self.answer


class VisualTrackingEnv(Replayed[Observation, NDArray[np.float64]]):
    """The target in the images of a vehicle that moves along a given path.

    An episode is one level; `reset` counts them as in station keeping. An observation has the next
    image, and the last one in which the target was shown with its corners. An action is what a
    tracker returns for the image: eight numbers x0 y0 to x3 y3 [px], and one that tells whether it
    has the target (from 0.5 on) or not.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 20}  # noqa: RUF012  # as Gymnasium's

    def __init__(
        self,
        *,
        benchmark: str,
        settings: Mapping[str, object] | None = None,
        render_mode: str | None = None,
    ) -> None:
        """Set up the environment; `settings` are the benchmark's.

        Raises
        ------
        ConfigurationInvalid, VehicleInvalid
            A setting, or the file of a vehicle, is not valid.
        ValueError
            There is no such render mode, or the images depend on the tracker (mode free).
        """
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise ValueError(f"render_mode must be rgb_array, not {render_mode!r}")
        self.render_mode = render_mode
        entry = registry.benchmark(benchmark)
        config: Any = entry.read(own_files.resolved(settings or {}))
        if getattr(config, "mode", "") == "free":
            raise ValueError("the environment needs a prescribed path: mode must not be free")
        self._config, self._experiment = config, entry.load()
        optics = self._experiment.camera(config, seed=0, trial=0, level=0).optics
        shape = (optics.height, optics.width)
        image = Box(0, 255, shape, np.uint8)
        points = Box(-np.inf, np.inf, (4, 2), np.float64)
        self.observation_space: gymnasium.Space[Any] = Dict(
            image=image, start_image=image, start_corners=points, started=Discrete(2)
        )
        far = 10.0 * max(shape)
        low, high = np.array([-far] * CORNERS + [0.0]), np.array([far] * CORNERS + [1.0])
        self.action_space: gymnasium.Space[Any] = Box(low, high, dtype=np.float64)
        self.metadata = self.metadata | {"render_fps": round(1.0 / config.control_period_s)}
        self._options = options_of(benchmark, config, ONE)
        self._episodes = Episodes(self._experiment, config)
        self._wrong_cost: float = getattr(self._experiment, "wrong_cost", 0.0)
        self._loop: OpenLoop | None = None
        self._row = np.zeros(WIDTH)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin the next level; with a seed, the first one of the run with that seed."""
        super().reset(seed=seed)
        self._start(episode := self._episodes.begin(seed, options, self.np_random))
        return self._observation(), episode.info() | self._truth()

    def _begin(self, episode: Episode) -> None:
        indices = {"seed": episode.seed, "trial": episode.trial, "level": episode.level}
        self._held, self._step = _Held(), 0
        self._loop = self._experiment.level(  # type: ignore[assignment]  # mode is not free
            self._config, self._held, **indices
        )
        self._camera = self._experiment.camera(self._config, **indices)
        self._show()

    def _show(self) -> None:
        """Start the tracker if that is due, and render the image that comes next."""
        loop = self._running
        self._started = loop.starts(self._step)
        if self._started:
            loop.step(self._step, self._row)
            self._step += 1
        self._image = self._camera.grey(loop.motion(self._step), loop.frame(self._step))

    @property
    def _running(self) -> OpenLoop:
        if self._loop is None:
            raise gymnasium.error.ResetNeeded("call reset() before step() and render()")
        return self._loop

    def step(
        self, action: NDArray[np.float64]
    ) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Take the corners in the present image and show the next one.

        The reward is 1 if they are within 5 px of the true ones, and 0 if the action says that it
        has no target. For other corners it is 0, or -1 where the benchmark lets wrong answers cost.
        Its mean over the images of a level is what the benchmark scores there.

        Raises
        ------
        ValueError
            The action is not nine finite numbers.
        """
        numbers = np.asarray(action, dtype=np.float64)
        if numbers.shape != self.action_space.shape or not np.isfinite(numbers).all():
            raise ValueError(f"an action is {CORNERS + 1} finite numbers, not {action!r}")
        result: tuple[Observation, float, bool, bool, dict[str, Any]] = self._advance(
            numbers.copy()
        )
        return result

    def _take(
        self, numbers: NDArray[np.float64]
    ) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        corners = numbers[:CORNERS].reshape(4, 2).copy()
        self._held.answer = Track(corners, bool(numbers[CORNERS] >= 0.5), 0.0, 0)
        self._running.step(self._step, self._row)
        self._step += 1
        right = self._row[_CORNER_ERROR] <= FAR_PX
        worth = 0.0 if not self._row[_OK] else 1.0 if right else 0.0 - self._wrong_cost
        truth, over = self._truth(), self._step >= self._config.control_steps_per_level
        if not over:
            self._show()
        return self._observation(), worth, False, over, truth

    def _observation(self) -> Observation:
        return {
            "image": self._image.copy(),
            "start_image": self._held.image.copy(),
            "start_corners": self._held.corners.copy(),
            "started": int(self._started),
        }

    def _truth(self) -> dict[str, Any]:
        """Return the truth of the last image that was answered, or that started the tracker."""
        row = self._row
        return {
            "pose": row[INDEX["x"] : INDEX["yaw"] + 1].copy(),
            "target": row[INDEX["target_x"] : INDEX["target_y"] + 1].copy(),
            "tracker_error": float(row[_CORNER_ERROR]),
        }

    @property
    def telemetry(self) -> NDArray[np.float64]:
        """The row of telemetry of the last image that was answered, without the time that took."""
        row = self._row.copy()
        row[STEP_US] = 0.0
        return row

    def render(self) -> NDArray[np.uint8] | None:
        """Return the present image in colour, (H, W, 3) red, green, blue."""
        if self.render_mode is None:
            return None
        loop = self._running
        image = self._camera.colour(loop.motion(self._step), loop.frame(self._step))
        return np.ascontiguousarray(image[..., ::-1])
