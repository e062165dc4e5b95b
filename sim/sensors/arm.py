"""Sensors of an arm: encoders of its joints, motor currents, a force sensor, and touch.

They are read at every control step. Their noise has a stream of its own and is drawn in advance, as
much for each step, so that it does not depend on what is read.
"""

import numpy as np

from seamark.sim.numerics.arrays import Array

# [rad or m] D: a step of a 12-bit absolute encoder is 2 pi / 4096; uniform within it
ENCODER_SIGMA = 4.4e-4
SPEED_SIGMA = 5e-3  # [rad/s or m/s] E: difference of two such readings, filtered over 0.1 s
EFFORT_SHARE = 0.02  # of the greatest effort. E: class of current sensors in motor drives
FORCE_SIGMA_N = 0.25  # E: resolution of six-axis sensors for some 300 N
TORQUE_SIGMA_N_M = 0.01  # E: the same for some 10 N m
TOUCH_N = 1.0  # E: a switch below a rubber pad


class ArmSensors:
    """The sensors of one arm over one level."""

    def __init__(
        self,
        rng: np.random.Generator,
        *,
        readings: int,
        efforts: Array,
        scale: float,
        encoder_bias: Array | float = 0.0,
    ) -> None:
        """Set up sensors.

        Parameters
        ----------
        readings : int
            Greatest number of readings.
        efforts : (a,) [N m or N]
            Greatest effort of each motor.
        scale : float
            By which all noise is multiplied.
        encoder_bias : (a,) [rad or m], optional
            Constant error of each encoder.
        """
        motors = len(efforts)
        sigmas = [
            np.full(motors, ENCODER_SIGMA),
            np.full(motors, SPEED_SIGMA),
            EFFORT_SHARE * np.asarray(efforts),
            np.full(3, FORCE_SIGMA_N),
            np.full(3, TORQUE_SIGMA_N_M),
        ]
        sigma = scale * np.concatenate(sigmas)
        self._noise = sigma * rng.standard_normal((readings, len(sigma)))
        self._noise[:, :motors] += encoder_bias

    def read(self, reading: int, true: Array, touch_n: Array, out: Array) -> None:
        """Write what is read at a control step.

        Parameters
        ----------
        true : (3 a + 6,)
            Coordinates, speeds and efforts of the motors' joints, force [N] and torque [N m].
        touch_n : (f,) [N]
            Contact force on each feeler.
        out : (3 a + 6 + f,)
            The observation's fields of an arm, in their order.
        """
        count = len(true)
        out[:count] = true + self._noise[reading]
        out[count:] = touch_n >= TOUCH_N
