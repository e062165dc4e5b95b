"""The learned entry that looks: from the pixels of the vehicle's camera to commands."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from seamark.sim.control.observation import VEHICLE_CAMERA, Observation
from seamark.sim.control.position.pixels.eye import Eye
from seamark.sim.control.position.pixels.hand import STEPS, Hand
from seamark.sim.control.position.pixels.reckoning import Reckoning

WEIGHTS = Path(__file__).with_name("weights.npz")


class Controller:
    """Finds the target in each image, remembers where it is, and steers by a learned policy.

    It uses nothing of the tracker. Config: `images` (it needs those of the vehicle's camera).
    """

    label = "From pixels: learned eye and hand"

    def __init__(self, config: Mapping[str, Any]) -> None:
        with np.load(WEIGHTS) as stored:
            parts: dict[str, dict[str, Any]] = {"eye": {}, "hand": {}}
            for name in stored.files:
                part, _, array = name.partition("_")
                parts[part][array] = stored[name]
        self.eye, self.hand = Eye(parts["eye"]), Hand(parts["hand"])
        self.reckoning = Reckoning(config)

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
        if self.steps % STEPS == 0:
            self.command = self.hand.decide(observation, self.reckoning.error())
        self.steps += 1
        return self.command
