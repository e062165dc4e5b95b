"""Observations of a station-keeping environment: which parts they have, images among them."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box, Dict
from numpy.typing import NDArray

from seamark.gym.spaces import STATE
from seamark.sim.camera.camera import GREEN
from seamark.sim.camera.survey import TARGET
from seamark.sim.engine.world import target_and_optics
from seamark.sim.fleet.images import ImageKind
from seamark.sim.settings.experiment import ExperimentSettings

CORNER_NUMBERS = 9  # four corners, and whether the tracker has the target
IMAGE, DEPTH, SEGMENTATION, CORNERS = "image", "depth", "segmentation", "corners"
PARTS = (STATE, CORNERS, IMAGE, DEPTH, SEGMENTATION)
OF_IMAGES = {IMAGE, DEPTH, SEGMENTATION}
IMAGE_SIZE = (84, 84)  # [px] width and height, unless another one is asked for
GREY, RGB = "grey", "rgb"
CHANNELS = {GREY: (GREEN,), RGB: (0, 1, 2)}  # those of the camera, in the order of the image
Parts = Mapping[str, NDArray[Any]]


class ObservationParts:
    """What the observations of an environment have."""

    def __init__(
        self, config: ExperimentSettings, observation: str, size: tuple[int, int], channels: str
    ) -> None:
        """Take the options of an environment; raises ValueError if there is no such one."""
        self.names = observation.split("+")
        if unknown := [name for name in self.names if name not in PARTS]:
            raise ValueError(f"observation is {unknown[0]!r}, but its parts are {', '.join(PARTS)}")
        if len(set(self.names)) < len(self.names):
            raise ValueError(f"observation {observation!r} has a part twice")
        if channels not in CHANNELS:
            raise ValueError(f"channels must be one of {', '.join(CHANNELS)}, not {channels!r}")
        width, height = size
        usual = target_and_optics(config)[1]
        # The whole height of the camera's image is in view, and of its width what fits.
        focal_px = usual.focal_px * height / usual.height
        optics = replace(usual, width=width, height=height, focal_px=focal_px)
        surveyed = not {DEPTH, SEGMENTATION}.isdisjoint(self.names)
        self.images: ImageKind | None = None
        if not OF_IMAGES.isdisjoint(self.names):
            drawn = IMAGE in self.names
            self.images = ImageKind(optics, CHANNELS[channels], drawn=drawn, surveyed=surveyed)

    def space(self, state: Box) -> gymnasium.Space[Any]:
        """Return the space of observations, given that of packed ones."""
        spaces: dict[str, Box] = {
            STATE: state,
            CORNERS: Box(-np.inf, np.inf, (CORNER_NUMBERS,), state.dtype.type),
        }
        if self.images is not None:
            optics, channels = self.images.optics, self.images.channels
            size = optics.height, optics.width
            spaces |= {
                IMAGE: Box(0, 255, (*size, len(channels)), np.uint8),
                DEPTH: Box(0, np.inf, (*size, 1), np.float32),
                SEGMENTATION: Box(0, TARGET, (*size, 1), np.uint8),
            }
        if len(self.names) == 1:
            return spaces[self.names[0]]
        return Dict({name: spaces[name] for name in self.names})

    def of(self, parts: Parts) -> Any:
        """Return an observation: an array, or a dict of several."""
        if len(self.names) == 1:
            return parts[self.names[0]]
        return {name: parts[name] for name in self.names}
