"""A smooth path around a place: where the vehicle is at a time, whatever anybody makes of it.

Each of the six coordinates of the pose is the sum of two sinusoids with seeded phases and periods,
so that no two levels have the same path and nobody can learn it.
"""

from collections.abc import Sequence

import numpy as np

from seamark.sim.numerics.libm import PI, sincos

SHARES = (0.65, 0.35)  # of the amplitude: the slow and the quick sinusoid; E
PERIODS = (1.0, 0.41)  # of the nominal period; E, no small whole ratio
LEAST_PERIOD, MOST_PERIOD = 0.8, 1.25  # a coordinate's own period, as a factor; E


class Path:
    """Pose and velocity as functions of time."""

    def __init__(
        self,
        centre: Sequence[float],
        amplitudes: Sequence[float],
        *,
        period_s: float,
        random: np.random.Generator,
    ) -> None:
        """Draw a path.

        Parameters
        ----------
        centre, amplitudes : (6,) [m, rad]
            The pose never leaves `centre` by more than `amplitudes`.
        """
        self._centre = [float(value) for value in centre]
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

    def at(self, t: float) -> tuple[list[float], list[float]]:
        """Return the pose (6) [m, rad] in the world and the velocity (6) [m/s, rad/s] in the body.

        Formulas: Fossen 2021, sections 2.2.1 (rotation) and 2.2.2 (rates of the Euler angles).
        """
        pose, rate = list(self._centre), [0.0] * 6
        for i, waves in enumerate(self._waves):
            for amplitude, speed, phase in waves:
                s, c = sincos(speed * t + phase)
                pose[i] += amplitude * s
                rate[i] += amplitude * speed * c
        return pose, _in_body(pose, rate)


def _between(low: float, high: float, share: float) -> float:
    return low + (high - low) * share


def _in_body(pose: Sequence[float], rate: Sequence[float]) -> list[float]:
    """Return the body's velocities of a pose that changes at this rate."""
    (sr, cr), (sp, cp), (sy, cy) = (sincos(angle) for angle in pose[3:])
    x, y, z, roll, pitch, yaw = rate
    ahead = cy * x + sy * y
    aside = cy * y - sy * x
    below = sp * ahead + cp * z
    return [
        cp * ahead - sp * z,
        cr * aside + sr * below,
        cr * below - sr * aside,
        roll - sp * yaw,
        cr * pitch + sr * cp * yaw,
        cr * cp * yaw - sr * pitch,
    ]
