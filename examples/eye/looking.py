"""Images of currents-v2 with where the target is in them, in states that a driver visits."""

from typing import Any, Protocol

import gymnasium
import numpy as np

import seamark.gym  # noqa: F401  # registers the environments
from seamark.sim.control.observation import VEHICLE_CAMERA, Observation
from seamark.sim.control.position.pixels.controller import Controller
from seamark.sim.control.position.pixels.eye import (
    HEIGHT,
    HEIGHT_PX,
    WIDTH,
    WIDTH_PX,
    normalise,
)
from seamark.sim.registry import benchmark

BENCHMARK, ENVIRONMENT = "currents-v2", "seamark/StationKeeping-v2"
KINDS = ("girona500", "bluerov2-heavy")  # of vehicles, in even and in odd trials
LEVELS = 8
PERIOD_S, IMAGE_S = 0.05, 0.1
LEVEL_S = 30.0
KEPT = 5  # images, of which one is kept: the others are much alike
FARTHEST_M, FASTEST, FASTEST_TURN = 1.1, 0.6, 0.5
KP, KI, HEADING_GAIN = 0.8, 0.3, 0.5
# Where the fields are in an observation.
TIME, ERROR, ERROR_PX, VISIBLE, YAW = 0, slice(2, 4), slice(5, 7), 7, 17


class Driver(Protocol):
    """Steers many vehicles of one kind."""

    def begin(self, chosen: np.ndarray, states: np.ndarray) -> None:
        """Begin a level of the chosen vehicles."""

    def commands(self, states: np.ndarray, images: np.ndarray, new: np.ndarray) -> np.ndarray:
        """Return the commands (n, 4); `new` is which images have just come."""


class Wanderer:
    """Goes to a place near the target, and turns: it sees the true error, but not the images."""

    def __init__(self, count: int, random: np.random.Generator) -> None:
        self.random = random
        self.goal, self.integral = np.zeros((count, 2)), np.zeros((count, 2))
        self.heading = np.zeros(count)

    def begin(self, chosen: np.ndarray, states: np.ndarray) -> None:
        """Draw a place and a heading for each of the chosen vehicles."""
        count = int(chosen.sum())
        self.goal[chosen] = self.random.uniform(-FARTHEST_M, FARTHEST_M, (count, 2))
        self.heading[chosen] = self.random.uniform(-np.pi, np.pi, count)
        self.integral[chosen] = 0.0

    def commands(self, states: np.ndarray, images: np.ndarray, new: np.ndarray) -> np.ndarray:
        """Return the commands of a PI law."""
        off = states[:, ERROR] - self.goal * states[:, VISIBLE, None]
        self.integral = np.clip(self.integral + PERIOD_S * KI * off, -FASTEST, FASTEST)
        turn = (self.heading - states[:, YAW] + np.pi) % (2.0 * np.pi) - np.pi
        still = np.zeros(len(states))
        speeds = np.clip(KP * off + self.integral, -FASTEST, FASTEST)
        rate = np.clip(HEADING_GAIN * turn, -FASTEST_TURN, FASTEST_TURN)
        return np.column_stack([speeds, still, rate])


class Pupil:
    """The entry itself, with the eye as it is so far: a controller for each vehicle."""

    def __init__(self, count: int, kind: str, weights: dict[str, np.ndarray]) -> None:
        config = benchmark(BENCHMARK).read({"vehicle": kind, "images": VEHICLE_CAMERA})
        self.controllers = [Controller(config.for_program(), weights) for _ in range(count)]
        self.image_t = np.zeros(count)

    def begin(self, chosen: np.ndarray, states: np.ndarray) -> None:
        """Reset the controllers of the chosen vehicles."""
        for i in np.flatnonzero(chosen):
            self.controllers[i].reset({})
            self.image_t[i] = states[i, TIME]

    def commands(self, states: np.ndarray, images: np.ndarray, new: np.ndarray) -> np.ndarray:
        """Return what the controllers command."""
        # Images come in the order in which they were taken, ten a second from the start of a level.
        self.image_t[new] += IMAGE_S
        return np.array(
            [
                controller.step(Observation(np.append(state, t), images={VEHICLE_CAMERA: image}))
                for controller, state, t, image in zip(
                    self.controllers, states, self.image_t, images, strict=True
                )
            ]
        )


class Shown:
    """Images as the eye gets them, and labels: whether the target is seen, and where [px]."""

    def __init__(self) -> None:
        self.images: list[np.ndarray] = []  # (HEIGHT, WIDTH)
        self.labels: list[np.ndarray] = []  # (3,)
        self.framed = np.zeros(((HEIGHT + 2) * (WIDTH + 2), 1), np.float32)

    def add(self, image: np.ndarray, state: np.ndarray) -> None:
        """Take an image (480, 640) and the observation with which it came."""
        normalise(image, self.framed)
        inner = self.framed.reshape(HEIGHT + 2, WIDTH + 2)[1:-1, 1:-1]
        self.images.append(inner.astype(np.float16))
        self.labels.append(np.array([state[VISIBLE], *state[ERROR_PX]], np.float32))


def look(shown: Shown, kind: str, driver: Driver, *, seed: int, count: int, seconds: float) -> None:
    """Add images of vehicles with the seeds from `seed` on, which begin with all levels alike.

    The true corners come as late as the images, so the observation with a new image has its label.
    """
    times = {"level_duration_s": LEVEL_S, "settle_s": 0.25 * LEVEL_S}
    envs: Any = gymnasium.make_vec(
        ENVIRONMENT,
        num_envs=count,
        observation="image+state",
        image_size=(WIDTH_PX, HEIGHT_PX),
        settings={"tracker": "truth", "vehicle": kind} | times,
    )
    every = np.arange(count)
    seen, _ = envs.reset(seed=seed)
    for level in range(LEVELS):
        mask = every % LEVELS == level
        seen, _ = envs.reset(options={"reset_mask": mask, "trial": 0, "level": level})
    begun, ended = np.ones(count, np.bool_), np.zeros(count, np.bool_)
    since, before = every % KEPT, np.full((1, 1, 1), -1)
    for _ in range(round(seconds / PERIOD_S)):
        images, states = seen["image"][..., 0], seen["state"]
        some = images[:, ::97, ::89].copy()  # enough pixels to tell an image from another
        new = (some != before).any(axis=(1, 2))
        before = some
        driver.begin(begun, states)
        since[new] += 1
        for i in np.flatnonzero(new & (since >= KEPT)):
            shown.add(images[i], states[i])
            since[i] = 0
        commands = driver.commands(states, images, new & ~begun)
        seen, _, terminated, truncated, _ = envs.step(commands)
        begun, ended = ended, terminated | truncated
    envs.close()
