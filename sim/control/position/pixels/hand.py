"""The hand: a small network that turns the error and the vehicle's own motion into commands.

It is the policy of `examples/ppo`, whose `features.py` has the same features for many vehicles at
once, with last bits that depend on the processor. Here every processor gets the same ones.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.control.observation import Observation
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.libm import exp, sincos

STEPS = 2  # control steps of 0.05 s for each command
PERIOD_S = 0.05 * STEPS
TOOL_M = (0.8, -0.1)  # forward and starboard of the body's origin, 1 m before the camera
FASTEST_TURN = 0.6  # rad/s
LONGEST_INTEGRAL = 2.0  # m s
MEANS_S = (0.5, 3.0)  # over which the means of past commands reach back
SHARES = tuple(1.0 - exp(-PERIOD_S / reach_s) for reach_s in MEANS_S)
SHARE_OF_TURNING = 1.0 - exp(-PERIOD_S)
FIVE, EIGHT = 5, 8  # thrusters of the two vehicles
Pair = tuple[float, float]


class Hand:
    """Decides on a command every other control step."""

    def __init__(self, weights: Mapping[str, NDArray[Any]]) -> None:
        """Take weights0 (inputs, outputs), biases0 (outputs,), and so on."""
        self._layers = [
            (weights[f"weights{n}"].astype(np.float64), weights[f"biases{n}"].astype(np.float64))
            for n in range(len(weights) // 2)
        ]
        self.reset()

    def reset(self) -> None:
        """Begin a level."""
        self.integral: Pair = (0.0, 0.0)  # [m s] north and east
        self.command = (0.0, 0.0, 0.0)  # surge, sway [m/s], yaw rate [rad/s]
        self.means: list[Pair] = [(0.0, 0.0) for _ in MEANS_S]  # [m/s] north and east
        self.turning = 0.0  # [rad/s]
        self.eight = False

    def decide(self, observation: Observation, error: Pair) -> list[float]:
        """Return surge, sway, heave [m/s] and yaw rate [rad/s].

        `error` is how far the camera has to move, forward and starboard [m].
        """
        value = np.array(self._features(observation, error))
        for number, (weights, biases) in enumerate(self._layers):
            value = layer(value, weights, biases, number < len(self._layers) - 1)
        surge, sway, rate = (_clipped(each, 1.0) for each in value.tolist())
        rate *= FASTEST_TURN
        surge = _clipped(surge + rate * TOOL_M[1], 1.0)
        sway = _clipped(sway - rate * TOOL_M[0], 1.0)
        self.command = surge, sway, rate
        return [surge, sway, 0.0, rate]

    def _features(self, o: Observation, error: Pair) -> Sequence[float]:
        yaw, rate, thrust = o.attitude.item(2), o.rates.item(2), o.thrust.tolist()
        sine, cosine = sincos(yaw)
        x, y = error[0] + cosine - 1.0, error[1] - sine  # of the tool
        off = cosine * x - sine * y, sine * x + cosine * y
        north, east = (
            _clipped(known + PERIOD_S * more, LONGEST_INTEGRAL)
            for known, more in zip(self.integral, off, strict=True)
        )
        self.integral = north, east
        surge, sway, turn = self.command
        asked = cosine * surge - sine * sway, sine * surge + cosine * sway
        for number, (share, mean) in enumerate(zip(SHARES, self.means, strict=True)):
            self.means[number] = (
                mean[0] + share * (asked[0] - mean[0]),
                mean[1] + share * (asked[1] - mean[1]),
            )
        self.turning += SHARE_OF_TURNING * (turn - self.turning)
        self.eight = self.eight or (len(thrust) == EIGHT and any(thrust[FIVE:]))
        eight, five = [0.0] * EIGHT, [0.0] * FIVE
        if self.eight:
            eight = [each / 40.0 for each in thrust]
        else:
            five = [each / 60.0 for each in thrust[:FIVE]]
        ahead = [
            (cosine * mean[0] + sine * mean[1], cosine * mean[1] - sine * mean[0])
            for mean in (self.integral, *self.means)
        ]
        return [
            *(4.0 * _clipped(each, 1.0) for each in (x, y)),
            *(_clipped(20.0 * each, 1.0) for each in (x, y)),
            *(2.0 * each for each in ahead[0]),
            5.0 * (o.velocity.item(0) - rate * TOOL_M[1]),
            5.0 * (o.velocity.item(1) + rate * TOOL_M[0]),
            *(sine, cosine - 1.0),
            3.0 * rate,
            *self.command,
            *eight,
            *five,
            float(self.eight),
            *(3.0 * each for mean in ahead[1:] for each in mean),
            3.0 * self.turning,
            1.0,  # where the target is, is always known
        ]


@njit(cache=True, error_model="numpy")
def layer(value: Array, weights: Array, biases: Array, bent: bool) -> Array:
    """Return the output of a layer, (outputs,), summed in the order of its inputs."""
    out = biases.copy()
    for i in range(weights.shape[0]):
        for j in range(weights.shape[1]):
            out[j] += value[i] * weights[i, j]
    if bent:
        for j in range(out.shape[0]):
            out[j] = 1.0 - 2.0 / (exp(2.0 * out[j]) + 1.0)  # hyperbolic tangent
    return out


def _clipped(value: float, most: float) -> float:
    return min(max(value, -most), most)
