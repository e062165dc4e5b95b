"""Metrics of a vehicle that follows a route: how much of it, how closely, and at what cost.

In the formulas e is the distance of the vehicle's origin from the nearest point of the piece of the
route that is due [m], a is how far along the route it has got [m], and L the route's length. It
gets on only with e of at most `REACH_M`, and never back. A vehicle that was farther off may join
the route again up to `REJOIN_M` ahead; what it left out it has not followed.
"""

from collections.abc import Callable
from functools import cached_property

import numpy as np

from seamark.sim.metrics.energy import ENERGY, POWER, power_share
from seamark.sim.metrics.metric import RMS, LevelMetric, Metric, MetricGroup
from seamark.sim.metrics.tool_point import HELD_QUALITY, POWER_WEIGHT
from seamark.sim.metrics.windows import LevelFacts, Window
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.statistics import mean, percentile, root_mean_square
from seamark.sim.recording.telemetry import ROUTE_INDEX, Rows

# E: from a survey line down to a connector; each about 1.6 times the next
CIRCLES_M = (1.0, 0.63, 0.4, 0.25, 0.16, 0.1)
# E: how far ahead along the route the nearest point may be; less than what is between two parts of
# a route that come near each other, so that none of it can be skipped.
WINDOW_M = 1.0
REACH_M = CIRCLES_M[0]  # a vehicle farther off does not follow the route
REJOIN_M = 5.0  # E
COMPLETED_M = 0.05  # E: of the route that may be left when it counts as completed


class Following(Window):
    """The rows of a level in which a route is followed."""

    def __init__(self, rows: Rows, facts: LevelFacts) -> None:
        super().__init__(rows, facts)
        self.along_m: Array = rows[:, ROUTE_INDEX["route_along"]]
        self.length_m = float(rows[0, ROUTE_INDEX["route_length"]])
        self._error_m: Array = rows[:, ROUTE_INDEX["cross_track"]]

    @cached_property
    def steps(self) -> int:
        """Rows until the route was completed; all, if it was not."""
        done = np.flatnonzero(self.along_m >= self.length_m - COMPLETED_M)
        return int(done[0]) + 1 if done.size else len(self.rows)

    @property
    def completed(self) -> bool:
        """Whether the route was followed to its end."""
        return bool(self.along_m[-1] >= self.length_m - COMPLETED_M)

    @property
    def error_m(self) -> list[float]:
        """Distance from the route until it was completed [m]."""
        errors: list[float] = self._error_m[: self.steps].tolist()
        return errors

    @cached_property
    def followed(self) -> float:
        """Share of the route, 0 to 1, that was passed within each of the circles, averaged."""
        shares: list[float] = share_followed(self.rows, 0.0).tolist()
        return sum(shares)


def share_followed(rows: Rows, along_m: float) -> Array:
    """Return the share of the route that each row adds, (k,), averaged over the circles.

    `along_m` is how far along the route the vehicle was before the first row.
    """
    gained = np.diff(rows[:, ROUTE_INDEX["route_along"]], prepend=along_m)
    gained[gained > WINDOW_M] = 0.0  # it was out of reach, and joined the route farther on
    errors = rows[:, ROUTE_INDEX["cross_track"]]
    inside = sum((errors <= radius).astype(np.float64) for radius in CIRCLES_M)
    shares: Array = gained * inside / (len(CIRCLES_M) * rows[0, ROUTE_INDEX["route_length"]])
    return shares


def _metric(
    name: str, label: str, unit: str, formula: str, compute: Callable[[Following], float]
) -> LevelMetric[Following]:
    return LevelMetric(
        name=name, label=label, unit=unit, better="lower", formula=formula, compute=compute
    )


QUALITY: LevelMetric[Following] = LevelMetric(
    name="followed",
    label="Followed",
    unit="",
    better="higher",
    meaning="share of the route that was followed closely, less a little for the power",
    formula="mean over the radii "
    + ", ".join(f"{radius:g}" for radius in CIRCLES_M)
    + " m of the share of the route that was passed with e within the radius, "
    f"times (1 - {POWER_WEIGHT:g} power_share)",
    compute=lambda level: level.followed * (1.0 - POWER_WEIGHT * power_share(level)),
)
PROGRESS: LevelMetric[Following] = LevelMetric(
    name="progress_percent",
    label="Progress",
    unit="%",
    better="higher",
    meaning="of the route, whatever the distance within reach",
    formula="100 a / L at the end",
    compute=lambda level: 100.0 * float(level.along_m[-1]) / level.length_m,
)
CROSS_TRACK: LevelMetric[Following] = LevelMetric(
    name="cross_track_rmse_m",
    label="RMS cross-track error",
    unit="m",
    better="lower",
    meaning="until the route was completed",
    formula="sqrt(mean of e^2)",
    over=RMS,
    compute=lambda level: root_mean_square(level.error_m),
)
_OWN: tuple[LevelMetric[Following], ...] = (
    QUALITY,
    PROGRESS,
    CROSS_TRACK,
    _metric(
        "cross_track_mean_m",
        "Mean cross-track error",
        "m",
        "mean of e",
        lambda level: mean(level.error_m),
    ),
    _metric(
        "cross_track_p95_m",
        "95th percentile of the cross-track error",
        "m",
        "95th percentile of e over the control steps, interpolated",
        lambda level: percentile(level.error_m, 0.95),
    ),
    LevelMetric(
        name="route_completed",
        label="Completed",
        unit="",
        better="higher",
        meaning="1 if the route was followed to its end",
        formula=f"1 if L - a at the end <= {COMPLETED_M:g} m, else 0",
        compute=lambda level: float(level.completed),
    ),
    _metric(
        "route_s",
        "Time to the end",
        "s",
        "time at which the route was completed; the whole level, if it was not",
        lambda level: level.steps * level.dt,
    ),
)
GROUP = MetricGroup("Following a route", _OWN)
METRICS = (*_OWN, POWER, ENERGY)
HELD = Metric("held", "Held", "", "higher", meaning=f"followed of at least {HELD_QUALITY:g}")
