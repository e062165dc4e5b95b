"""A Kalman filter of position, velocity, water and DVL bias, for surge and sway."""

from collections import deque
from collections.abc import Sequence

from seamark.sim.control.observation import Observation
from seamark.sim.control.position.vehicle_model import AXES, VehicleModel

POSITION, VELOCITY, WATER, BIAS = range(4)  # [m], [m/s], [m/s²], [m/s]
STATES = range(4)
START_SIGMA = (0.1, 0.01, 0.1, 0.02)  # E: at the start of a level, in the units above
CAMERA_SIGMA_M = 0.003  # E: half a pixel at 2.27 m
DVL_SIGMA_M_S = 0.003  # E: twice that of the instrument: the vehicle moves between the readings
FORCE_NOISE = 0.01  # [m/s² per root hertz] E: what the nominal model gets wrong
BIAS_NOISE = 1e-4  # [m/s per root second] E


class KalmanFilter:
    """Position and velocity, the water's push and the bias of the DVL, for surge and sway alike.

    p' = v, v' = thrust/M + d, d and b are random walks; the camera measures p, the DVL v + b, at
    their own rates (Kalman 1960; Fossen 2021, ch. 13). Both axes have one covariance.
    """

    def __init__(self, water_noise: float) -> None:
        """Set up a filter; `water_noise` is the density of d' [m/s³ per root hertz]."""
        self.states = [[0.0] * 4 for _ in AXES]
        self._covariance = [[START_SIGMA[i] ** 2 * (i == j) for j in STATES] for i in STATES]
        self._noise = (0.0, FORCE_NOISE**2, water_noise**2, BIAS_NOISE**2)

    def predict(self, accelerations: Sequence[float], turned_rad: float, dt: float) -> None:
        """Advance by dt [s]: accelerations by the thrusters [m/s²], and the vehicle's turn."""
        for state, acceleration in zip(self.states, accelerations, strict=True):
            rise = (acceleration + state[WATER]) * dt
            state[POSITION] += (state[VELOCITY] + 0.5 * rise) * dt
            state[VELOCITY] += rise
        surge, sway = self.states
        for at in (POSITION, VELOCITY, WATER):  # vectors turn against the vehicle
            surge[at], sway[at] = (
                surge[at] + turned_rad * sway[at],
                sway[at] - turned_rad * surge[at],
            )
        self.spread(dt)

    def spread(self, dt: float) -> None:
        """Advance the covariance by dt [s]."""
        matrix = self._covariance
        for at in (POSITION, VELOCITY):
            matrix[at] = [a + dt * b for a, b in zip(matrix[at], matrix[at + 1], strict=True)]
        for row, noise, own in zip(matrix, self._noise, STATES, strict=True):
            row[POSITION] += dt * row[VELOCITY]
            row[VELOCITY] += dt * row[WATER]
            row[own] += noise * dt

    def correct(self, seen: tuple[int, ...], innovations: Sequence[float], sigma: float) -> None:
        """Correct by a measurement of the sum of some states, with its standard deviation."""
        row = [sum(self._covariance[at][i] for at in seen) for i in STATES]
        variance = sum(row[at] for at in seen) + sigma * sigma
        for state, innovation in zip(self.states, innovations, strict=True):
            for i in STATES:
                state[i] += row[i] / variance * innovation
        for i in STATES:
            for j in STATES:
                self._covariance[i][j] -= row[i] * row[j] / variance


class StateEstimator:
    """The filter in the loop: thrusts predict, images and readings of the DVL correct.

    Images are compared with the estimate of the moment at which they were taken.
    """

    def __init__(self, model: VehicleModel, *, water_m_s2: float, delay_steps: int) -> None:
        """Set up the estimator.

        Parameters
        ----------
        water_m_s2 : float [m/s² per root hertz]
            Noise density with which the water may accelerate.
        delay_steps : int
            Age of an image in control steps.
        """
        self._model = model
        self._water_noise = water_m_s2 * max(model.sensitivity)
        self.past: deque[list[float]] = deque(maxlen=delay_steps + 1)  # positions, oldest first
        self.reset()

    def reset(self) -> None:
        """Forget the last level."""
        self.filter = KalmanFilter(self._water_noise)
        self.past.clear()

    def update(self, observation: Observation) -> None:
        """Predict by the present thrust, then correct by what is new; after the model's update."""
        filtered, model = self.filter, self._model
        pushes = [model.force[axis] / model.mass[axis] for axis in AXES]
        filtered.predict(pushes, observation.rates.item(2) * observation.dt, observation.dt)
        self.past.append([state[POSITION] for state in filtered.states])
        if observation.target_visible:
            errors = observation.error.tolist()
            innovations = [-errors[axis] - self.past[0][axis] for axis in AXES]
            filtered.correct((POSITION,), innovations, CAMERA_SIGMA_M)
        if model.fresh:
            measured = observation.velocity.tolist()
            innovations = [
                measured[axis] - filtered.states[axis][VELOCITY] - filtered.states[axis][BIAS]
                for axis in AXES
            ]
            filtered.correct((VELOCITY, BIAS), innovations, DVL_SIGMA_M_S)
