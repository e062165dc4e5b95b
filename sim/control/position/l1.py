"""L1 adaptive control: the disturbance is estimated fast and cancelled behind a low-pass."""

from collections.abc import Mapping, Sequence
from pkgutil import resolve_name
from typing import Any

from seamark.sim.control.observation import Observation
from seamark.sim.control.position.vehicle_model import AXES, VehicleModel

LATENCY_S = 0.1  # E: as for the regulator of `lqr.py`, so that one value suits all vehicles


class Controller:
    """Station keeping by L1 adaptive control with a piecewise-constant law, and a P law on heading.

        p̂' = v + σ1 - a (p̂ - p),   v̂' = thrust/M + σ2 - a (v̂ - v)
        σ = -a / (exp(a T) - 1) × error of the predictor,   at each measurement, T after the last
        force = -M (ω² p + 2 ω (v + σ1) + σ2),   σ1 and σ2 behind the low-pass c / (s + c)

    Predictor and adaptation are those of Hovakimyan and Cao (2010, L1 Adaptive Control Theory,
    3.3), for each measured state. At a measurement, σ cancels what is left of the predictor's
    error, so the next error is what the time in between added. Water and wrong numbers of the model
    act where the thrust does (matched, σ2); a bias of the DVL does not (unmatched, σ1), and is
    cancelled as the speed that it feigns. The force becomes a velocity reference by the nominal
    model. Between two readings of the DVL, v follows thrust and σ2.

    Config: `l1_bandwidth`, `l1_predictor_1_s` a, `l1_filter_1_s` c, `heading_gain_1_s`.
    """

    label = "L1 adaptive"

    def __init__(self, config: Mapping[str, Any]) -> None:
        self.heading_gain = config["heading_gain_1_s"]
        self.model = VehicleModel(config)
        self.bandwidth = config["l1_bandwidth"] / (self.model.lag_s + LATENCY_S)  # [1/s] ω
        rate, cutoff = config["l1_predictor_1_s"], config["l1_filter_1_s"]
        exp = resolve_name("seamark.sim.numerics.libm:exp")  # compiled: only for runs
        period, reading = config["control_period_s"], 1.0 / config["dvl_rate_hz"]
        # Of position and speed, at the rates of their measurements.
        self.gains = [rate / (exp(rate * time) - 1.0) for time in (period, reading)]
        self.passed = 1.0 - exp(-cutoff * period)  # by the low-pass in a step
        self.reset({})

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Forget the last level."""
        self.model.reset()
        self.position: list[float] = []  # [m] p̂ from the last image; empty without one
        self.predicted: list[float] = []  # [m/s] v̂ from the last reading; empty before the first
        self.speed = [0.0, 0.0]  # [m/s] v
        self.drift, self.water = [0.0, 0.0], [0.0, 0.0]  # [m/s] σ1, [m/s²] σ2
        self.slow_drift, self.slow_water = [0.0, 0.0], [0.0, 0.0]  # behind the low-pass

    def step(self, observation: Observation) -> Sequence[float]:
        """Return surge, sway, heave [m/s] and yaw rate [rad/s]."""
        self.model.update(observation)
        self._adapt_speed(observation)
        self._adapt_position(observation)
        errors = observation.error.tolist()
        command = [0.0, 0.0, 0.0, -self.heading_gain * observation.attitude.item(2)]
        for axis in AXES:
            self.slow_water[axis] += self.passed * (self.water[axis] - self.slow_water[axis])
            self.slow_drift[axis] += self.passed * (self.drift[axis] - self.slow_drift[axis])
            speed = self.speed[axis] + self.slow_drift[axis]
            wanted = self.bandwidth * (self.bandwidth * errors[axis] - 2.0 * speed)
            wanted -= self.slow_water[axis]
            command[axis] = self.model.reference(axis, self.model.mass[axis] * wanted)
        return command

    def _adapt_speed(self, observation: Observation) -> None:
        """Predict the speed by the thrust; at a reading of the DVL, adapt σ2 and start anew."""
        pushes = [self.model.force[axis] / self.model.mass[axis] for axis in AXES]
        if self.predicted:
            for axis in AXES:
                self.predicted[axis] += pushes[axis] * observation.dt
                self.speed[axis] += (pushes[axis] + self.slow_water[axis]) * observation.dt
        if self.model.fresh:
            measured = observation.velocity.tolist()[: len(AXES)]
            for axis, predicted in enumerate(self.predicted):
                self.water[axis] = self.gains[1] * (measured[axis] - predicted)
            self.predicted, self.speed = [*measured], [*measured]

    def _adapt_position(self, observation: Observation) -> None:
        """Compare the position in the image with what the speed predicted; adapt σ1."""
        if not observation.target_visible:
            self.position = []
            return
        found = [-error for error in observation.error.tolist()[: len(AXES)]]
        if self.position:
            turned, dt = observation.rates.item(2) * observation.dt, observation.dt
            surge, sway = self.position
            before = (surge + turned * sway, sway - turned * surge)  # turned against the vehicle
            for axis in AXES:
                predicted = before[axis] + self.speed[axis] * dt
                self.drift[axis] = self.gains[0] * (found[axis] - predicted)
        self.position = found
