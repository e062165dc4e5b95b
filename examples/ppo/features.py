"""What the policy sees of vehicles and what its actions mean, the same in training and in a box.

Rows are vehicles. Their observations are those of docs/training.md, with eight thrusts.
"""

from typing import Any

import numpy as np

STEPS = 2  # control steps of 0.05 s for each action: there are ten images a second
PERIOD_S = 0.05 * STEPS
FEATURES, ACTIONS = 34, 3
TOOL_M = np.array([0.8, -0.1])  # forward and starboard of the body's origin, 1 m before the camera
FASTEST_TURN = 0.6  # rad/s
LONGEST_INTEGRAL = 2.0  # m s
MEANS_S = (0.5, 3.0)  # over which the means of past commands reach back
GIRONA_THRUSTERS = 5
# Where the fields are in an observation.
ERROR, VISIBLE, VELOCITY = slice(2, 4), slice(7, 8), slice(9, 11)
YAW, YAW_RATE, THRUST = 17, 20, slice(21, 29)


def rotated(angle: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Return vectors (n, 2) turned by angles (n,)."""
    cos, sin = np.cos(angle), np.sin(angle)
    x, y = vectors[:, 0], vectors[:, 1]
    return np.stack([cos * x - sin * y, sin * x + cos * y], axis=1)


def tool_error(observations: np.ndarray) -> np.ndarray:
    """Return how far the tool has to move along the axes of the body [m], (n, 2).

    The error of an observation is the camera's at the heading of the station. The score is about
    the tool, which stays in its place while the vehicle turns about it.
    """
    yaw = observations[:, YAW]
    return observations[:, ERROR] + np.stack([np.cos(yaw) - 1.0, -np.sin(yaw)], axis=1)


def row(observation: Any) -> np.ndarray:
    """Return a controller's observation as those of one vehicle, (1, 29)."""
    numbers = np.zeros((1, THRUST.stop))
    numbers[0, ERROR], numbers[0, VISIBLE] = observation.error[:2], observation.target_visible
    numbers[0, VELOCITY] = observation.velocity[:2]
    numbers[0, YAW], numbers[0, YAW_RATE] = observation.attitude[2], observation.rates[2]
    numbers[0, THRUST.start : THRUST.start + len(observation.thrust)] = observation.thrust
    return numbers


class Features:
    """What vehicles have seen and done in their levels, as the policy gets it.

    Integral and means are kept along north and east, where the current stays the same while the
    vehicle turns, and seen along its own axes.
    """

    def __init__(self, vehicles: int) -> None:
        self.eight = np.zeros((vehicles, 1), np.bool_)  # thrusters, not five
        self.integral = np.zeros((vehicles, 2))  # m s
        self.commands = np.zeros((vehicles, 3))  # surge, sway [m/s], yaw rate [rad/s]
        self.means = [np.zeros((vehicles, 2)) for _ in MEANS_S]  # m/s
        self.turning = np.zeros((vehicles, 1))  # rad/s

    def forget(self, chosen: np.ndarray) -> None:
        """Begin a level of the chosen vehicles, whose thrusters stay the same or are seen soon."""
        for kept in (self.eight, self.integral, self.commands, *self.means, self.turning):
            kept[chosen] = 0

    def see(self, observations: np.ndarray, chosen: np.ndarray) -> np.ndarray:
        """Remember the observations of the chosen vehicles; return their features, float32."""
        yaw, error = observations[:, YAW], tool_error(observations)
        thrust, commands = observations[:, THRUST], self.commands[chosen]
        more = thrust[:, GIRONA_THRUSTERS:].any(axis=1, keepdims=True)
        eight = self.eight[chosen] = self.eight[chosen] | more
        integral = self.integral[chosen] + PERIOD_S * rotated(yaw, error)
        self.integral[chosen] = np.clip(integral, -LONGEST_INTEGRAL, LONGEST_INTEGRAL)
        asked = rotated(yaw, commands[:, :2])
        for mean, reach_s in zip(self.means, MEANS_S, strict=True):
            mean[chosen] += (1.0 - np.exp(-PERIOD_S / reach_s)) * (asked - mean[chosen])
        turning = self.turning[chosen]
        turning += (1.0 - np.exp(-PERIOD_S)) * (commands[:, 2:] - turning)
        self.turning[chosen] = turning
        rate = observations[:, YAW_RATE, None]
        velocity = observations[:, VELOCITY] + rate * np.abs(TOOL_M[::-1])  # of the tool
        parts = [  # each about 1 where it matters
            4.0 * np.clip(error, -1.0, 1.0),
            np.clip(20.0 * error, -1.0, 1.0),
            2.0 * rotated(-yaw, self.integral[chosen]),
            5.0 * velocity,
            np.stack([np.sin(yaw), np.cos(yaw) - 1.0], axis=1),
            3.0 * rate,
            commands,
            np.where(eight, thrust / 40.0, 0.0),
            np.where(eight, 0.0, thrust[:, :GIRONA_THRUSTERS] / 60.0),
            eight,
            *(3.0 * rotated(-yaw, mean[chosen]) for mean in self.means),
            3.0 * turning,
            observations[:, VISIBLE],
        ]
        return np.concatenate(parts, axis=1).astype(np.float32)

    def command(self, actions: np.ndarray) -> np.ndarray:
        """Return surge, sway, heave [m/s] and yaw rate [rad/s] of all vehicles, (n, 4).

        An action is the velocity of the tool and the yaw rate in shares of the limits: so an action
        that turns alone leaves the tool where it is.
        """
        surge, sway, rate = np.clip(actions.astype(np.float64), -1.0, 1.0).T
        rate = FASTEST_TURN * rate
        surge = np.clip(surge + rate * TOOL_M[1], -1.0, 1.0)
        sway = np.clip(sway - rate * TOOL_M[0], -1.0, 1.0)
        self.commands = np.stack([surge, sway, rate], axis=1)
        return np.stack([surge, sway, np.zeros_like(surge), rate], axis=1)
