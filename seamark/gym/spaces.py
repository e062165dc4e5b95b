"""Observation and action spaces of the station-keeping environments.

An observation is the packed observation of a controller: `sim/control/observation.py` has names,
units and meaning of its fields, and `named` returns them by name.
"""

from typing import Any

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from seamark.sim.control.observation import FIELDS, PER_THRUSTER, Observation
from seamark.sim.control.velocity_law import FASTEST_YAW_RAD_S
from seamark.sim.settings.station_keeping import StationKeepingSettings
from seamark.sim.vehicles import load

VELOCITY, THRUSTERS = "velocity", "thrusters"
ACTIONS = (VELOCITY, THRUSTERS)
_UNBOUNDED = np.inf
# Least and greatest value of a field; the others have no bound.
_BOUNDS = {
    "t": (0.0, _UNBOUNDED),
    "dt": (0.0, 0.5),
    "target_visible": (0.0, 1.0),
    "target_age": (0.0, _UNBOUNDED),
    "velocity_valid": (0.0, 1.0),
}


def named(observation: NDArray[np.float64]) -> Observation:
    """Return an observation by name, as an uploaded controller gets it: `named(obs).error`."""
    return Observation(np.asarray(observation, dtype=np.float64))


def most_thrusters(config: StationKeepingSettings) -> int:
    """Return the number of thrusters of the vehicle; of several, that of the one with most."""
    return max(len(load(name).thrusters) for name in config.vehicles())


def observation_space(config: StationKeepingSettings) -> Box:
    """Return the space of packed observations; the thrusts a vehicle does not have are 0."""
    low: list[float] = []
    high: list[float] = []
    for name, count, _unit, _meaning in FIELDS:
        numbers = most_thrusters(config) if count == PER_THRUSTER else max(count, 1)
        least, greatest = _BOUNDS.get(name, (-_UNBOUNDED, _UNBOUNDED))
        low += [least] * numbers
        high += [greatest] * numbers
    return Box(np.array(low), np.array(high), dtype=np.float64)


def action_space(config: StationKeepingSettings, action: str) -> Box:
    """Return the space of actions.

    Parameters
    ----------
    action
        VELOCITY: surge, sway, heave [m/s] and yaw rate [rad/s], within the limits at which the
        vehicle saturates them. THRUSTERS: commands in [-1, 1], one per thruster; those that a
        vehicle does not have are ignored.

    Raises
    ------
    ValueError
        There is no such action.
    """
    if action not in ACTIONS:
        raise ValueError(f"action must be one of {', '.join(ACTIONS)}, not {action!r}")
    if action == THRUSTERS:
        size: Any = np.ones(most_thrusters(config))
    else:
        size = np.array([*[config.reference_limit_m_s] * 3, FASTEST_YAW_RAD_S])
    return Box(-size, size, dtype=np.float64)
