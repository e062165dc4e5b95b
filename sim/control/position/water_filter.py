"""A Kalman filter for a vehicle that turns: its water keeps its velocity over ground."""

from collections import deque
from collections.abc import Sequence
from pkgutil import resolve_name

from seamark.sim.control.observation import Observation
from seamark.sim.control.position.kalman_filter import (
    BIAS,
    CAMERA_SIGMA_M,
    DVL_SIGMA_M_S,
    POSITION,
    VELOCITY,
    WATER,
    KalmanFilter,
)
from seamark.sim.control.position.vehicle_model import AXES, VehicleModel

Level = tuple[float, float]  # of the horizontal plane


class WaterFilter:
    """The filter in the loop of a vehicle that turns about another point than its origin.

    Between two steps the water keeps its velocity over ground, as neither its force nor its
    acceleration of the vehicle does: they depend on the speed through it and on the side that the
    hull turns to it. The position is that of the camera, which images measure, the velocity that
    of the origin, which the DVL measures.
    """

    def __init__(
        self, model: VehicleModel, camera_m: Sequence[float], *, water_m_s2: float, delay_steps: int
    ) -> None:
        """Set up the filter.

        Parameters
        ----------
        camera_m
            Place of the camera in the body, (3,) [m].
        water_m_s2 : float [m/s² per root hertz]
            Noise density with which the water may accelerate.
        delay_steps : int
            Age of an image in control steps.
        """
        self._model, self._camera = model, camera_m
        self._water_noise = water_m_s2 * max(model.sensitivity)
        self._sincos = resolve_name("seamark.sim.numerics.libm:sincos")  # compiled: only for runs
        self.past: deque[list[float]] = deque(maxlen=delay_steps + 1)  # positions, oldest first
        self.reset()

    def reset(self) -> None:
        """Forget the last level."""
        self._filter = KalmanFilter(self._water_noise)
        self.states = self._filter.states
        self.past.clear()

    def update(self, observation: Observation) -> None:
        """Predict by the present thrust, then correct by what is new; after the model's update."""
        self._predict(observation.rates.tolist(), observation.dt)
        self.past.append([state[POSITION] for state in self.states])
        if observation.target_visible:
            errors = observation.error.tolist()
            innovations = [-errors[axis] - self.past[0][axis] for axis in AXES]
            self._filter.correct((POSITION,), innovations, CAMERA_SIGMA_M)
        if self._model.fresh:
            measured = observation.velocity.tolist()
            innovations = [
                measured[axis] - state[VELOCITY] - state[BIAS]
                for axis, state in enumerate(self.states)
            ]
            self._filter.correct((VELOCITY, BIAS), innovations, DVL_SIGMA_M_S)

    def through(self) -> Level:
        """Return the velocity of the water past the vehicle [m/s], by the drag that it causes."""
        model = self._model
        surge, sway = (
            model.speed_of(axis, model.mass[axis] * self.states[axis][WATER]) for axis in AXES
        )
        return surge, sway

    def pushes(self, turn_rad_s: float) -> list[float]:
        """Return the force of the water on surge and sway [N], by drag and by turning in it.

        The added mass of sway turns into that of surge and back (Fossen 2021, ch. 6.3).
        """
        model, through = self._model, self.through()
        turning = (model.added[1] - model.added[0]) * turn_rad_s
        return [
            model.mass[axis] * self.states[axis][WATER] - turning * through[1 - axis]
            for axis in AXES
        ]

    def _predict(self, rates: Sequence[float], dt: float) -> None:
        model, states = self._model, self.states
        roll, pitch, yaw = rates
        ahead, side, down = self._camera
        swept = (pitch * down - yaw * side, yaw * ahead - roll * down)  # [m/s] the camera, turning
        water = [past + state[VELOCITY] for past, state in zip(self.through(), states, strict=True)]
        pushes = self.pushes(yaw)
        for axis, state in enumerate(states):
            rise = (model.force[axis] + pushes[axis]) / model.mass[axis] * dt
            state[POSITION] += (state[VELOCITY] + swept[axis] + 0.5 * rise) * dt
            state[VELOCITY] += rise
        turned = self._sincos(yaw * dt)
        places = _turned([state[POSITION] for state in states], turned)
        speeds = _turned([state[VELOCITY] for state in states], turned)
        for axis, speed in enumerate(_turned(water, turned)):
            state = states[axis]
            state[POSITION], state[VELOCITY] = places[axis], speeds[axis]
            state[WATER] = model.drag(axis, speed - speeds[axis]) / model.mass[axis]
        self._filter.spread(dt)


def _turned(vector: Sequence[float], turned: Level) -> Level:
    """Return a vector over ground as a vehicle has it that has turned by (sine, cosine)."""
    sine, cosine = turned
    surge, sway = vector
    return cosine * surge + sine * sway, cosine * sway - sine * surge
