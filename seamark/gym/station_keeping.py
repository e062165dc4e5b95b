"""Station keeping as a Gymnasium environment."""

from typing import Any

import numpy as np

from seamark.gym.episodes import Episode
from seamark.gym.images import (
    CORNERS,
    DEPTH,
    GREY,
    IMAGE,
    IMAGE_SIZE,
    SEGMENTATION,
    ObservationParts,
)
from seamark.gym.spaces import STATE, observation_space
from seamark.gym.vehicle import Observation, Packed, VehicleEnv
from seamark.sim.camera.camera import GREEN, Camera
from seamark.sim.engine.images_in_loop import Exposure, ImagesInLoop, Source
from seamark.sim.engine.reward import goal, reward_of
from seamark.sim.fleet.images import ImageKind


class StationKeepingEnv(VehicleEnv):
    """A vehicle that keeps its place: a step earns by the state in which it ends.

    See `sim/engine/reward.py` and `VehicleEnv`.
    """

    def __init__(
        self,
        *,
        observation: str = STATE,
        image_size: tuple[int, int] = IMAGE_SIZE,
        channels: str = GREY,
        **options: Any,
    ) -> None:
        """Set up the environment.

        Parameters
        ----------
        observation
            "state": the packed observation of a controller; "corners": the tracker's corners [px]
            as they arrive and whether it has the target, (9,); "image": the newest image of the
            camera, (height, width, channels) of uint8, as late and as often as a controller gets
            it; "depth" [m] along the optical axis, float32, and "segmentation", 0 the bottom and 1
            the target, both (height, width, 1) and of the same instant, without water. Several
            joined by a plus, such as "image+state", are a dict.
        image_size
            Width and height of these images [px]; the camera's whole height is in view.
        channels
            "grey" or "rgb".
        options
            As of `VehicleEnv`, with its exceptions.

        Raises
        ------
        ValueError
            There is no such observation, or none with channels or a size like that.
        """
        super().__init__(**options)
        config = self._config
        self._shown = ObservationParts(config, observation, image_size, channels)
        if observation != STATE:
            self.observation_space = self._shown.space(observation_space(config, self._dtype))

    def _begin(self, episode: Episode) -> None:
        super()._begin(episode)
        world = self._world
        mount = world.camera.optics.mount_m
        self._goal = goal(world.plant.vehicle, world.station, mount, world.tool_m)
        if images := self._shown.images:
            place = {"seed": episode.seed, "trial": episode.trial, "level": episode.level}
            camera = self._experiment.camera(self._config, optics=images.optics, **place)
            self._images = ImagesInLoop(
                self._sources(camera, images),
                control_period_s=self._config.control_period_s,
                late=world.conditions.camera_delay_steps,
            )

    def _sources(self, camera: Camera, kind: ImageKind) -> dict[str, Source]:
        """Return what renders each part of the observation that comes with an image."""

        def image(motion: Packed, frame: int) -> Packed:
            if kind.channels == (GREEN,):
                return camera.grey(motion, frame)[:, :, None]
            return np.ascontiguousarray(camera.colour(motion, frame)[..., ::-1])

        every: dict[str, Source] = {
            IMAGE: image,
            DEPTH: lambda motion, _: camera.survey(motion).depth[:, :, None],
            SEGMENTATION: lambda motion, _: camera.survey(motion).labels[:, :, None],
        }
        return {name: render for name, render in every.items() if name in self._shown.names}

    def _sense(self) -> None:
        super()._sense()
        if self._shown.images is not None:
            motion, frame = self._running.motion(), self._first_frame + self._step
            self._images.step(Exposure(self._step, 0.0, motion, frame))

    def _observation(self) -> Observation:
        if self._shown.names == [STATE]:
            return super()._observation()
        parts: dict[str, Packed] = {}
        if STATE in self._shown.names and isinstance(packed := super()._observation(), np.ndarray):
            parts[STATE] = packed
        if CORNERS in self._shown.names:
            corners, ok = self._running.seen_corners()
            parts[CORNERS] = np.append(corners, ok).astype(self._dtype)
        if self._shown.images is not None:
            parts |= {name: image.copy() for name, image in self._images.newest.items()}
        shown: Observation = self._shown.of(parts)
        return shown

    def _reward(self) -> float:
        return float(reward_of(self._row, self._goal))
