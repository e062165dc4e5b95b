"""A smooth prescribed path around a pose, independent of any tracker or controller.

Each of the six coordinates of the pose is the sum of two sinusoids with seeded phases and periods,
so that no two levels have the same path and none can be learnt.
"""

from collections.abc import Sequence

import numpy as np

from seamark.sim.numerics.libm import PI, sincos

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
        self._centre = [float(value) for value in centre]
        self._drift = [float(value) for value in drift]
        draws = random.random((6, 2, 2)).tolist()
        self._waves = [
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

    def pose_and_velocity(self, t: float) -> tuple[list[float], list[float]]:
        """Return the pose (6) [m, rad], world frame, and the velocity (6) [m/s, rad/s], body frame.

        Formulas: Fossen 2021, sections 2.2.1 (rotation) and 2.2.2 (rates of the Euler angles).
        """
        pose = [c + d * t for c, d in zip(self._centre, self._drift, strict=True)]
        rate = list(self._drift)
        for i, waves in enumerate(self._waves):
            for amplitude, frequency, phase in waves:
                s, c = sincos(frequency * t + phase)
                pose[i] += amplitude * s
                rate[i] += amplitude * frequency * c
        return pose, _body_velocity(pose, rate)


def _between(low: float, high: float, share: float) -> float:
    return low + (high - low) * share


def _body_velocity(pose: Sequence[float], rate: Sequence[float]) -> list[float]:
    """Return the body-frame velocity for a pose and its rate of change."""
    (sr, cr), (sp, cp), (sy, cy) = (sincos(angle) for angle in pose[3:])
    x, y, z, roll, pitch, yaw = rate
    forward = cy * x + sy * y
    starboard = cy * y - sy * x
    down = sp * forward + cp * z
    return [
        cp * forward - sp * z,
        cr * starboard + sr * down,
        cr * down - sr * starboard,
        roll - sp * yaw,
        cr * pitch + sr * cp * yaw,
        cr * cp * yaw - sr * pitch,
    ]
