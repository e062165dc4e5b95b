"""MPC: moves over a horizon within the thrusters' limits, with a disturbance observer."""

from collections import deque
from collections.abc import Mapping, Sequence
from operator import mul
from pkgutil import resolve_name
from typing import Any

import numpy as np

from seamark.sim.control.observation import Observation
from seamark.sim.control.position.kalman_filter import StateEstimator
from seamark.sim.control.position.vehicle_model import AXES, VehicleModel
from seamark.sim.numerics.arrays import Array
from seamark.sim.vehicles import load

LATENCY_S = 0.1  # E: as for the regulator of `lqr.py`, so that one value suits all vehicles
YAW = 5  # row of the allocation
# E: of the published limits, which moves may ask for: thrusters may be stronger than published, and
# only a command beyond the limit is sure to get all that there is. The best of 1, 1.2 and 1.5.
MARGIN = 1.5


class Controller:
    """Station keeping by linear model predictive control, and a P law on the heading.

    At each step the moves over the horizon that cost least within the limits of each thruster
    (`seamark.sim.control.mpc.horizon`) are computed, and the first is made (Mayne et al. 2000,
    Automatica 36(6)). The disturbance is estimated by a Kalman filter, whose two disturbances of
    each axis, water and DVL bias, are as many as its measurements: so there is no offset (Maeder,
    Borrelli and Morari 2009). Commands that are still on their way are part of the prediction. What
    the thrusters give to the moment about the vertical is not there for the moves.

    Config: `mpc_bandwidth`, `mpc_horizon_s`, `mpc_water_m_s2`, `mpc_camera_delay_s`,
    `mpc_command_delay_s`, `heading_gain_1_s`.
    """

    label = "MPC with disturbance observer"

    def __init__(self, config: Mapping[str, Any]) -> None:
        self.heading_gain = config["heading_gain_1_s"]
        self.model = VehicleModel(config)
        period = config["control_period_s"]
        self.estimator = StateEstimator(
            self.model,
            water_m_s2=config["mpc_water_m_s2"],
            delay_steps=round(config["mpc_camera_delay_s"] / period),
        )
        under_way = round(config["mpc_command_delay_s"] / period)
        self.under_way: deque[list[float]] = deque(maxlen=under_way)  # [m/s²] oldest first
        self.thrusters = Thrusters(config["vehicle"])
        horizon = resolve_name("seamark.sim.control.mpc.horizon")  # compiled: only for runs
        tuning = horizon.Tuning(
            dt=period,
            steps=max(round(config["mpc_horizon_s"] / period), 1),
            lag_s=self.model.lag_s,
            bandwidth_1_s=config["mpc_bandwidth"] / (self.model.lag_s + LATENCY_S),
        )
        self._advance, self._situation = horizon.advance, horizon.Situation
        self.horizon = horizon.Horizon(tuning, self.thrusters.per_acceleration(self.model.mass))
        self.reference = np.zeros((len(AXES), tuning.steps, 3))  # the station
        self._states, self._disturbances = np.zeros((len(AXES), 3)), np.zeros(len(AXES))

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Forget the last level."""
        self.model.reset()
        self.estimator.reset()
        self.horizon.reset()
        self.under_way.clear()

    def step(self, observation: Observation) -> Sequence[float]:
        """Return surge, sway, heave [m/s] and yaw rate [rad/s]."""
        self.model.update(observation)
        self.estimator.update(observation)
        yaw_rate = self.aim(observation)
        for axis in AXES:
            position, speed, water, _bias = self.estimator.filter.states[axis]
            state = (position, speed, self.model.force[axis] / self.model.mass[axis])
            for moves in self.under_way:
                state = self._advance(self.horizon.step, state, moves[axis], water)
            self._states[axis], self._disturbances[axis] = state, water
        room = self.thrusters.room(observation.thrust.tolist())
        situation = self._situation(self._states, self._disturbances, *room)
        asked = self.horizon.solve(situation, self.reference).tolist()
        self.under_way.append(asked)
        command = [0.0, 0.0, 0.0, yaw_rate]
        for axis in AXES:
            command[axis] = self.model.reference(axis, self.model.mass[axis] * asked[axis])
        return command

    def aim(self, observation: Observation) -> float:
        """Set the reference of the horizon in the present body frame; return the yaw rate."""
        return float(-self.heading_gain * observation.attitude.item(2))


class Thrusters:
    """The thrusters that act on surge and sway, and what each can give to them."""

    def __init__(self, vehicle: str) -> None:
        loaded = load(vehicle)
        self._lever = loaded.allocation()[YAW].tolist()  # [m]
        shares = resolve_name("seamark.sim.control.allocation:allocator")(loaded)  # (n, 6)
        horizontal = [row for row in shares.tolist() if any(row[axis] for axis in AXES)]
        self._shares = [[row[axis] for axis in AXES] for row in horizontal]
        self._yaw_shares = np.array([row[YAW] for row in horizontal])
        self._forward, self._reverse = loaded.curve.limits.value

    def per_acceleration(self, masses: Sequence[float]) -> Array:
        """Return the share of its greatest thrust for 1 m/s² on surge and on sway, (m, 2)."""
        rows = [list(map(mul, row, masses)) for row in self._shares]
        return np.array(rows).reshape(-1, len(AXES)) / self._forward

    def room(self, thrust: Sequence[float]) -> tuple[Array, Array]:
        """Return the least and greatest share of its thrust that is free for surge and sway, (m,).

        The rest is what the present thrusts [N] give to the moment about the vertical.
        """
        moment = sum(map(mul, self._lever, thrust))
        taken = self._yaw_shares * moment
        low = (-MARGIN * self._reverse - taken) / self._forward
        return low, (MARGIN * self._forward - taken) / self._forward
