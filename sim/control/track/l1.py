"""Following a route with an L1 adaptive velocity: what pushes is estimated fast and cancelled."""

from collections.abc import Mapping, Sequence
from pkgutil import resolve_name
from typing import Any

from seamark.sim.control.observation import Observation
from seamark.sim.control.position.vehicle_model import AXES, VehicleModel
from seamark.sim.control.track.guidance import SPEED_GAIN_1_S, Level, LineOfSight

# E: rate a of the predictor and bandwidth c of the low-pass, those of currents-v2
PREDICTOR_1_S, FILTER_1_S = 0.5, 1.0


class AdaptiveLineOfSight(LineOfSight):
    """Line of sight whose velocity a piecewise-constant L1 law keeps up against the water.

        v̂' = thrust/M + σ - a (v̂ - v),   σ = -a / (exp(a T) - 1) × (v̂ - v) at each DVL reading
        force = M (k (wanted - v) - σ), with σ behind the low-pass c / (s + c)

    As `seamark.sim.control.position.l1` has it for the speeds (Hovakimyan and Cao 2010, 3.3); its
    unmatched part is left out, since no position is measured beside the speed. k is
    `SPEED_GAIN_1_S`.
    """

    label = "Line of sight, L1 adaptive velocity"

    def __init__(self, config: Mapping[str, Any]) -> None:
        super().__init__(config)
        self._model = VehicleModel(config)
        exp = resolve_name("seamark.sim.numerics.libm:exp")  # compiled: only for runs
        self._found = PREDICTOR_1_S / (exp(PREDICTOR_1_S / config["dvl_rate_hz"]) - 1.0)
        self._passed = 1.0 - exp(-FILTER_1_S * config["control_period_s"])

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Forget the water of the last level."""
        super().reset(level)
        self._model.reset()
        self._predicted: list[float] = []  # [m/s] v̂ from the last reading; empty before the first
        self._speeds = [0.0, 0.0]  # [m/s] v, between two readings by thrust and water
        self._water, self._slow = [0.0, 0.0], [0.0, 0.0]  # [m/s²] σ, and behind the low-pass

    def _look_at_water(self, observation: Observation, sine: float, cosine: float) -> None:
        model, dt = self._model, observation.dt
        model.update(observation)
        pushes = [model.force[axis] / model.mass[axis] for axis in AXES]
        if self._predicted:
            for axis in AXES:
                self._predicted[axis] += pushes[axis] * dt
                self._speeds[axis] += (pushes[axis] + self._slow[axis]) * dt
        if model.fresh:
            measured = observation.velocity.tolist()[: len(AXES)]
            for axis, predicted in enumerate(self._predicted):
                self._water[axis] = self._found * (measured[axis] - predicted)
            self._predicted, self._speeds = [*measured], [*measured]
        for axis in AXES:
            self._slow[axis] += self._passed * (self._water[axis] - self._slow[axis])

    def _level(
        self, observation: Observation, wanted: Level, sine: float, cosine: float
    ) -> Sequence[float]:
        """Return the references with which the thrusters push as the law wants."""
        references = []
        for axis in AXES:
            error = wanted[axis] - self._speeds[axis]
            force = self._model.mass[axis] * (SPEED_GAIN_1_S * error - self._slow[axis])
            references.append(self._model.reference(axis, force))
        return references
