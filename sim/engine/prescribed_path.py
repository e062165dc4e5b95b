"""A smooth prescribed path around a pose, independent of any tracker or controller.

Each of the six coordinates of the pose is the sum of two sinusoids with seeded phases and periods,
so that no two levels have the same path and none can be learnt.
"""

from collections.abc import Sequence

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.numerics.libm import PI, sincos

Array = NDArray[np.float64]

SHARES = (0.65, 0.35)  # of the amplitude: slow and fast sinusoid; E
PERIODS = (1.0, 0.41)  # of the nominal period; E: far from a ratio of small integers
LEAST_PERIOD, MOST_PERIOD = 0.8, 1.25  # factor of each coordinate's period; E


class PrescribedPath:
    """Pose and velocity as functions of time."""

    def __init__(
        self,
        centre: Sequence[float],
        amplitudes: Sequence[float],
        *,
        period_s: float,
        random: np.random.Generator,
        drift: Sequence[float] = (0.0,) * 6,
    ) -> None:
        """Draw a path.

        Parameters
        ----------
        centre, amplitudes : (6,) [m, rad]
            The pose never leaves `centre` by more than `amplitudes`, apart from the drift.
        drift : (6,) [m/s, rad/s]
            Rate at which the centre moves, world frame.
        """
        self._line = np.array([centre, drift], dtype=np.float64)
        draws = random.random((6, 2, 2)).tolist()
        waves = [
            [
                (
                    amplitude * share,
                    2.0 * PI / (period_s * period * _between(LEAST_PERIOD, MOST_PERIOD, draw[0])),
                    2.0 * PI * draw[1],
                )
                for share, period, draw in zip(SHARES, PERIODS, pair, strict=True)
            ]
            for amplitude, pair in zip(amplitudes, draws, strict=True)
        ]
        self._waves = np.array(waves, dtype=np.float64)

    def pose_and_velocity(self, t: float) -> tuple[list[float], list[float]]:
        """Return the pose (6) [m, rad], world frame, and the velocity (6) [m/s, rad/s], body frame.

        Formulas: Fossen 2021, sections 2.2.1 (rotation) and 2.2.2 (rates of the Euler angles).
        """
        both = np.empty((2, 6))
        _follow(self._line, self._waves, float(t), both)
        pose, velocity = both.tolist()
        return pose, velocity


def _between(low: float, high: float, share: float) -> float:
    return low + (high - low) * share


@njit(cache=True, nogil=True, error_model="numpy")
def _follow(line: Array, waves: Array, t: float, out: Array) -> None:
    """Write the pose and the body-frame velocity, (2, 6), at a time."""
    pose, velocity = out[0], out[1]
    rate = line[1].copy()
    for i in range(6):
        pose[i] = line[0, i] + line[1, i] * t
        for j in range(waves.shape[1]):
            amplitude, frequency, phase = waves[i, j, 0], waves[i, j, 1], waves[i, j, 2]
            s, c = sincos(frequency * t + phase)
            pose[i] += amplitude * s
            rate[i] += amplitude * frequency * c
    sr, cr = sincos(pose[3])
    sp, cp = sincos(pose[4])
    sy, cy = sincos(pose[5])
    x, y, z, roll, pitch, yaw = rate[0], rate[1], rate[2], rate[3], rate[4], rate[5]
    forward = cy * x + sy * y
    starboard = cy * y - sy * x
    down = sp * forward + cp * z
    velocity[0] = cp * forward - sp * z
    velocity[1] = cr * starboard + sr * down
    velocity[2] = cr * down - sr * starboard
    velocity[3] = roll - sp * yaw
    velocity[4] = cr * pitch + sr * cp * yaw
    velocity[5] = cr * cp * yaw - sr * pitch
