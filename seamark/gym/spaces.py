"""Observation and action spaces of the station-keeping environments.

An observation is the packed observation of a controller: `sim/control/observation.py` has names,
units and meaning of its fields, and `named` returns them by name. With images it is a dict, of the
packed observation as STATE and the newest image of each camera.
"""

import math
from collections.abc import Mapping
from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box, Dict
from numpy.typing import DTypeLike, NDArray

from seamark.sim.control.observation import (
    ARM_FIELDS,
    DOCK_FIELDS,
    FIELDS,
    IMAGE_FIELDS,
    PER_FEELER,
    PER_MOTOR,
    PER_THRUSTER,
    ROUTE_FIELDS,
    SEARCH_FIELDS,
    Observation,
    arm_size,
    joint_limits,
)
from seamark.sim.control.velocity_law import FASTEST_YAW_RAD_S
from seamark.sim.engine.world import program_optics
from seamark.sim.settings.arm import NO_ARM
from seamark.sim.settings.station_keeping import StationKeepingSettings
from seamark.sim.vehicles import load
from seamark.sim.vehicles.linkage_reading import load_linkage

STATE, IMAGE = "state", "image_"  # keys of an observation with images; the camera's name follows
VELOCITY, THRUSTERS = "velocity", "thrusters"
ACTIONS = (VELOCITY, THRUSTERS)
_UNBOUNDED = np.inf
_ROUNDED = 1e-6  # by which a bound in float32 may lie beyond the limit
_SATURATED = (
    "An action is outside of the action space, so the vehicle saturates it: it does less than the "
    "policy wants. Bound the actions of the policy, or make the environment with "
    "normalise_actions=True if its actions are from -1 to 1. This is said once."
)
# Least and greatest value of a field; the others have no bound.
_BOUNDS = {
    "t": (0.0, _UNBOUNDED),
    "dt": (0.0, 0.5),
    "target_visible": (0.0, 1.0),
    "target_age": (0.0, _UNBOUNDED),
    "velocity_valid": (0.0, 1.0),
    "touch": (0.0, 1.0),
    "confidence": (0.0, 1.0),
    "fix_age": (-1.0, _UNBOUNDED),
    "fix_sigma": (0.0, _UNBOUNDED),
    "pipe_angle": (-math.pi, math.pi),
    "dock_age": (-1.0, _UNBOUNDED),
    "dock_sigma": (0.0, _UNBOUNDED),
    "light_visible": (0.0, 1.0),
    "image_t": (0.0, _UNBOUNDED),
}


def named(
    observation: NDArray[np.float64] | Mapping[str, NDArray[Any]],
    *,
    arm: str = NO_ARM,
    search: bool = False,
    route: bool = False,
    dock: bool = False,
) -> Observation:
    """Return an observation by name, as an uploaded controller gets it: `named(obs).error`.

    `arm` is the one that the vehicle carries, if any; `search` is whether its target has to be
    found first, as in mission-v1, `route` whether it follows one, as in track-v1, and `dock`
    whether it enters one, as in dock-v1.
    """
    size = None if arm == NO_ARM else arm_size(load_linkage(arm))
    images = None
    if isinstance(observation, Mapping):
        parts = observation
        observation = parts[STATE]
        images = {key.removeprefix(IMAGE): parts[key] for key in parts if key != STATE}
    packed = np.asarray(observation, dtype=np.float64)
    return Observation(packed, size, images, search=search, route=route, dock=dock)


def most_thrusters(config: StationKeepingSettings) -> int:
    """Return the number of thrusters of the vehicle; of several, that of the one with most."""
    return max(len(load(name).thrusters) for name in config.vehicles())


def with_images(state: Box, config: StationKeepingSettings) -> Box | Dict:
    """Return the space of observations, given that of packed ones."""
    shapes = {name: (each.height, each.width) for name, each in program_optics(config).items()}
    images = {IMAGE + name: Box(0, 255, shape, np.uint8) for name, shape in shapes.items()}
    return Dict({STATE: state, **images}) if images else state


def observation_space(config: StationKeepingSettings, dtype: DTypeLike = np.float64) -> Box:
    """Return the space of packed observations; the thrusts a vehicle does not have are 0."""
    low: list[float] = []
    high: list[float] = []
    arm = config.chosen_arm()
    size = arm and arm_size(arm)
    further = (
        *(ARM_FIELDS if size else ()),
        *(SEARCH_FIELDS if config.searches() else ()),
        *(ROUTE_FIELDS if config.has_route() else ()),
        *(DOCK_FIELDS if config.has_dock() else ()),
        *(IMAGE_FIELDS if config.cameras_of_program() else ()),
    )
    for name, count, _unit, _meaning in (*FIELDS, *further):
        numbers = most_thrusters(config) if count == PER_THRUSTER else max(count, 1)
        if size and count in {PER_MOTOR, PER_FEELER}:
            numbers = size.count(count)
        least, greatest = _BOUNDS.get(name, (-_UNBOUNDED, _UNBOUNDED))
        low += [least] * numbers
        high += [greatest] * numbers
    return Box(np.array(low, dtype), np.array(high, dtype), dtype=_checked(dtype))


class Actions:
    """What the actions of an environment mean.

    Attributes
    ----------
    space
        VELOCITY: surge, sway, heave [m/s] and yaw rate [rad/s], within the limits at which the
        vehicle saturates them. THRUSTERS: commands in [-1, 1], one per thruster; those that a
        vehicle does not have are ignored. The speeds of the arm's joints follow [rad/s or m/s],
        within those of its motors. Normalised: all numbers in [-1, 1].
    """

    def __init__(
        self,
        config: StationKeepingSettings,
        action: str,
        *,
        normalised: bool = False,
        dtype: DTypeLike = np.float64,
    ) -> None:
        """Set up; raises ValueError if there is no such action or type of numbers."""
        if action not in ACTIONS:
            raise ValueError(f"action must be one of {', '.join(ACTIONS)}, not {action!r}")
        if action == THRUSTERS:
            size = np.ones(most_thrusters(config))
        else:
            size = np.array([*[config.reference_limit_m_s] * 3, FASTEST_YAW_RAD_S])
        arm = config.chosen_arm()
        size = np.append(size, joint_limits(arm) if arm else [])
        self._scale = size if normalised else np.ones_like(size)
        self._most = size * (1.0 + _ROUNDED)
        bound = np.ones_like(size) if normalised else size
        self.space = Box((-bound).astype(dtype), bound.astype(dtype), dtype=_checked(dtype))
        self._warned = False

    def commands(self, actions: NDArray[np.floating[Any]]) -> NDArray[np.float64]:
        """Return the commands that actions mean, (..., k), and warn once if some are saturated."""
        commands = np.asarray(actions, dtype=np.float64)
        if commands.shape[-1:] == self._scale.shape:
            commands = commands * self._scale
            if not self._warned and (np.abs(commands) > self._most).any():
                self._warned = True
                gymnasium.logger.warn(_SATURATED)
        return commands


def _checked(dtype: DTypeLike) -> Any:
    if np.dtype(dtype) not in (np.float32, np.float64):
        raise ValueError(f"dtype must be float32 or float64, not {np.dtype(dtype)}")
    return np.dtype(dtype).type
