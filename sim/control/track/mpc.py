"""Following a route by model predictive control."""

from collections.abc import Mapping, Sequence
from operator import mul
from pkgutil import resolve_name
from typing import Any

import numpy as np

from seamark.sim.control.observation import Observation
from seamark.sim.control.position.kalman_filter import DVL_SIGMA_M_S, VELOCITY, WATER, KalmanFilter
from seamark.sim.control.position.mpc import LATENCY_S, Thrusters
from seamark.sim.control.position.vehicle_model import AXES
from seamark.sim.control.track.guidance import IntoFlow, Level
from seamark.sim.control.track.navigation import to_body

HORIZON_S = 3.0  # E
BANDWIDTH = 0.35  # E: times the sum of thruster lag and latency
WATER_M_S2 = 0.1  # [m/s² per root hertz] E: times the sensitivity of the hull


class RouteMpc(IntoFlow):
    """Plans the moves of the thrusters along the next seconds of the route, bow into the flow.

    The reference of each axis is the place on the route that the vehicle will have at the set speed
    after each step of the horizon, from the nearest point on; the moves that cost least within the
    limits of each thruster come of `seamark.sim.control.mpc.horizon`. The disturbance is that of a
    Kalman filter of thrust and DVL. Config: also `start_error_m`, `speed_m_s`.
    """

    label = "MPC along the route, bow into the flow"

    def __init__(self, config: Mapping[str, Any]) -> None:
        own = {"lookahead_m": config["speed_m_s"], "integral_gain": 0.0}
        super().__init__({**config, **own})
        model, dt = self._model, config["control_period_s"]
        self._thrusters = Thrusters(config["vehicle"])
        horizon = resolve_name("seamark.sim.control.mpc.horizon")  # compiled: only for runs
        tuning = horizon.Tuning(
            dt=dt,
            steps=round(HORIZON_S / dt),
            lag_s=model.lag_s,
            bandwidth_1_s=BANDWIDTH / (model.lag_s + LATENCY_S),
        )
        self._situation = horizon.Situation
        self._horizon = horizon.Horizon(tuning, self._thrusters.per_acceleration(model.mass))
        self._reference = np.zeros((len(AXES), tuning.steps, 3))
        self._states, self._disturbances = np.zeros((len(AXES), 3)), np.zeros(len(AXES))

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Forget the water of the last level."""
        super().reset(level)
        self._filter = KalmanFilter(WATER_M_S2 * max(self._model.sensitivity))
        self._horizon.reset()

    def _look_at_water(self, observation: Observation, sine: float, cosine: float) -> None:
        super()._look_at_water(observation, sine, cosine)
        model, dt = self._model, observation.dt
        pushes = [model.force[axis] / model.mass[axis] for axis in AXES]
        self._filter.predict(pushes, observation.rates.item(2) * dt, dt)
        if model.fresh:
            measured = observation.velocity.tolist()
            speeds = [state[VELOCITY] for state in self._filter.states]
            innovations = [measured[axis] - speeds[axis] for axis in AXES]
            self._filter.correct((VELOCITY,), innovations, DVL_SIGMA_M_S)

    def _level(
        self, observation: Observation, wanted: Level, sine: float, cosine: float
    ) -> Sequence[float]:
        """Return the references with which the thrusters make the first of the best moves."""
        model = self._model
        self._plan(observation.dt, sine, cosine)
        for axis in AXES:
            state = self._filter.states[axis]
            self._states[axis] = 0.0, state[VELOCITY], model.force[axis] / model.mass[axis]
            self._disturbances[axis] = state[WATER]
        room = self._thrusters.room(observation.thrust.tolist())
        situation = self._situation(self._states, self._disturbances, *room)
        moves = self._horizon.solve(situation, self._reference).tolist()
        forces = map(mul, model.mass, moves)
        return [model.reference(axis, force) for axis, force in zip(AXES, forces, strict=True)]

    def _plan(self, dt: float, sine: float, cosine: float) -> None:
        """Set the reference: places from that of the vehicle, and velocities, body frame."""
        guide, way_m, steps = self._guide, self._speed * dt, self._reference.shape[1]
        ahead = guide.ahead(way_m, steps)
        moving = way_m * np.arange(1, steps + 1) < guide.left_m
        north, east = ahead[:, 0] - guide.position[0], ahead[:, 1] - guide.position[1]
        speed_north, speed_east = (self._speed * moving * ahead[:, 3 + axis] for axis in AXES)
        places = to_body(north, east, (sine, cosine))
        speeds = to_body(speed_north, speed_east, (sine, cosine))
        for axis in AXES:
            self._reference[axis, :, 0], self._reference[axis, :, 1] = places[axis], speeds[axis]
