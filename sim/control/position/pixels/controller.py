"""The learned entry that looks: from the pixels of the vehicle's camera to commands."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from pkgutil import resolve_name
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seamark.sim.control.observation import VEHICLE_CAMERA, Observation

WEIGHTS = Path(__file__).with_name("weights.npz")
PARTS = (  # with what they need they load Numba and OpenCV: only for runs
    "seamark.sim.control.position.pixels.eye",
    "seamark.sim.control.position.pixels.hand",
    "seamark.sim.control.position.pixels.reckoning",
)
NEEDS_IMAGES = "pixels needs the images of the vehicle's camera: --set images=vehicle"


class Controller:
    """Finds the target in each image, remembers where it is, and steers by a learned policy.

    It uses nothing of the tracker. Config: `images` (it needs those of the vehicle's camera).
    """

    label = "From pixels: learned eye and hand"

    def __init__(
        self, config: Mapping[str, Any], weights: Mapping[str, NDArray[Any]] | None = None
    ) -> None:
        """Set up, with other weights than those that are kept here if there are some.

        Raises
        ------
        ValueError
            The settings do not ask for the images of the vehicle's camera.
        """
        if config.get("images") not in ("vehicle", "both"):
            raise ValueError(NEEDS_IMAGES)
        parts: dict[str, dict[str, NDArray[Any]]] = {"eye": {}, "hand": {}}
        for name, array in (weights or _kept()).items():
            part, _, of_part = name.partition("_")
            parts[part][of_part] = array
        eye, hand, reckoning = map(resolve_name, PARTS)
        self.eye, self.reckoning = eye.Eye(parts["eye"]), reckoning.Reckoning(config)
        self.hand, self.every = hand.Hand(parts["hand"]), hand.STEPS

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Forget the last level."""
        self.hand.reset()
        self.reckoning.reset()
        self.image_t, self.steps = -1.0, 0
        self.command: Sequence[float] = ()

    def step(self, observation: Observation) -> Sequence[float]:
        """Return surge, sway, heave [m/s] and yaw rate [rad/s]."""
        self.reckoning.move(observation)
        if observation.image_t != self.image_t:
            self.image_t = observation.image_t
            sight = self.eye.find(observation.images[VEHICLE_CAMERA])
            if sight is not None:
                self.reckoning.see(self.image_t, sight)
        if self.steps % self.every == 0:
            self.command = self.hand.decide(observation, self.reckoning.error())
        self.steps += 1
        return self.command


def _kept() -> Mapping[str, NDArray[Any]]:
    with np.load(WEIGHTS) as stored:
        return {name: stored[name] for name in stored.files}
