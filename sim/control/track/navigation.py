"""Where the vehicle is, by dead reckoning and acoustic fixes: a Kalman filter."""

from collections import deque

from seamark.sim.control.observation import Observation

AXES = (0, 1)  # north, east
DRIFT_M_S = 0.01  # E: of dead reckoning, from the bias of the DVL and of the compass
DRIFT_NOISE = 2e-3  # [m/s per root second] E: it turns with the heading
START_SHARE = 0.5  # standard deviation of each axis of a disc, as a share of its radius
LONGEST_DELAY_S = 30.0  # of fixes that are still used


class Navigation:
    """Position north and east of the start [m], and the error of dead reckoning [m/s].

    p' = v + b with v from DVL and compass, b a random walk; a fix measures p as it was when the
    beacon answered (Kalman 1960; Fossen 2021, ch. 13). The innovation is that of the past, the gain
    that of the present, which is nearly the same: the delay is short against how fast the
    covariance changes. Both axes have one covariance.
    """

    def __init__(self, start_error_m: float, *, fixes: bool = True) -> None:
        """Set up for a start that may be so far off; without `fixes` it is dead reckoning alone."""
        self._fixes, self._start_sigma = fixes, max(START_SHARE * start_error_m, 0.01)
        self.reset()

    def reset(self) -> None:
        """Begin a level at the origin."""
        self.position, self._drift = [0.0, 0.0], [0.0, 0.0]
        self._variance = [self._start_sigma**2, 0.0, DRIFT_M_S**2]  # of p, of p and b, of b
        self._past: deque[tuple[float, float]] = deque()  # positions, the newest last
        self._pinged_at = -1.0  # [s] when the last fix that was used was measured

    def update(self, observation: Observation, sine: float, cosine: float) -> None:
        """Take the measurements of a step; sine and cosine are those of the heading."""
        dt = observation.dt
        surge, sway = observation.velocity.item(0), observation.velocity.item(1)
        speeds = (cosine * surge - sine * sway, sine * surge + cosine * sway)
        for axis in AXES:
            self.position[axis] += (speeds[axis] + self._drift[axis]) * dt
        own, both, drift = self._variance
        self._variance = [
            own + dt * (2.0 * both + dt * drift),
            both + dt * drift,
            drift + dt * DRIFT_NOISE**2,
        ]
        self._past.append((self.position[0], self.position[1]))
        if len(self._past) * dt > LONGEST_DELAY_S:
            self._past.popleft()
        if self._fixes and observation.fix_age >= 0.0:
            self._take_fix(observation)

    def _take_fix(self, observation: Observation) -> None:
        age, dt = observation.fix_age, observation.dt
        measured_at = observation.t - age
        ago = round(age / dt)
        if measured_at <= self._pinged_at + 0.5 * dt or ago >= len(self._past):
            return
        self._pinged_at = measured_at
        own, both, drift = self._variance
        total = own + observation.fix_sigma**2
        past = self._past[-1 - ago]
        for axis in AXES:
            innovation = observation.fix.item(axis) - past[axis]
            self.position[axis] += own / total * innovation
            self._drift[axis] += both / total * innovation
        gain = own / total
        self._variance = [own - gain * own, both - gain * both, drift - both / total * both]
        self._past = deque(
            (
                north + gain * (observation.fix.item(0) - past[0]),
                east + gain * (observation.fix.item(1) - past[1]),
            )
            for north, east in self._past
        )
