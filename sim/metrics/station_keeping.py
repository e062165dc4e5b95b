"""Metrics of station keeping: computed from the telemetry of a level alone.

Each exists for the part of a level after the settle window and, with the prefix `whole_`, for the
whole level. In the formulas d is the true distance of the camera from its station [m], e that of
the target from the image centre [px], N the number of control steps, dt the control period.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from seamark.sim.metrics.energy import ENERGY
from seamark.sim.metrics.metric import (
    MAX,
    RMS,
    SUM,
    LevelMetric,
    Metric,
    MetricGroup,
    compute_all,
)
from seamark.sim.metrics.windows import (
    LOST_COLUMNS,
    LOST_PX,
    THRUST_COLUMNS,
    Level,
    LevelFacts,
    Window,
    percent,
)
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.exact_sums import exact_mean, exact_root_mean_square, exact_sum
from seamark.sim.numerics.statistics import mean, percentile
from seamark.sim.recording.telemetry import INDEX, Rows

SCORE_LENGTH_M = 0.25  # [m] RMSE at which a level earns half of its points
HELD_P95_M = (
    0.5  # [m] a level is held if 95 % of the time stays within and the target is never lost
)
CIRCLES_M = (0.1, 0.25, 0.5)  # [m] watch circles
SETTLED_M = 0.1  # [m]
FULL_THRUST = 0.98  # share of the limit from which a thruster counts as saturated; E
REBOUND_S = 0.5  # S: ExperimentMeasurer, contacts closer than this are one collision
VRX_BASE = 0.75  # VRX StationkeepingScoringPlugin
WHOLE = "whole_"  # prefix of the metrics over the whole length of a level


def settling_time(distance: Sequence[float], dt: float) -> float | None:
    """Return the time [s] from which the distance stays within `SETTLED_M`; None if it does not."""
    last_outside = -1
    for at, value in enumerate(distance):
        if not value <= SETTLED_M:
            last_outside = at
    return None if last_outside == len(distance) - 1 else (last_outside + 1) * dt


def points(rmse_m: float, lost_share: float) -> float:
    """Return the points of a level, 0 to 100: bounded, so one bad level costs at most its share."""
    return 100.0 / (1.0 + rmse_m / SCORE_LENGTH_M) * (1.0 - lost_share)


def _defined(values: Array) -> Array:
    """Return the values; nan alone if one is nan, since nan has no order."""
    return np.array([math.nan]) if np.isnan(values).any() else values


def _p95(values: Array) -> float:
    return percentile(np.sort(values).tolist(), 0.95)


def _largest(values: Array) -> float:
    return max(values.tolist(), default=math.nan)


def _distance_metrics(
    unit: str, symbol: str, what: str, column: str
) -> Iterable[LevelMetric[Window]]:
    """Yield RMSE, mean, 95th percentile and maximum of a column of distances."""

    def of(statistic: Any) -> Any:
        return lambda window: statistic(_defined(window.values(column)))

    metric = partial(LevelMetric, unit=unit, better="lower", reads=(column,))
    yield metric(
        name=f"rmse_{unit}",
        label=f"RMSE of the {what}",
        meaning="root mean square: large errors weigh more",
        formula=f"sqrt(sum {symbol}^2 / N)",
        over=RMS,
        compute=of(exact_root_mean_square),
    )
    yield metric(
        name=f"mae_{unit}",
        label=f"Mean {what}",
        formula=f"sum {symbol} / N",
        compute=of(exact_mean),
    )
    yield metric(
        name=f"p95_{unit}",
        label=f"95th percentile of the {what}",
        meaning=f"95 % of the time the {what} is smaller",
        formula=f"95th percentile of {symbol} over the control steps, interpolated",
        over=MAX,
        compute=of(_p95),
    )
    yield metric(
        name=f"max_{unit}",
        label=f"Maximum {what}",
        formula=f"max {symbol}",
        over=MAX,
        compute=of(_largest),
    )


def _mean_error_metric(axis: str, direction: str) -> LevelMetric[Window]:
    return LevelMetric(
        name=f"mean_{axis}_px",
        label=f"Mean {axis.upper()} error",
        unit="px",
        better="lower",
        meaning=f"steady-state error under a constant current, along image "
        f"{axis.upper()} ({direction})",
        formula=f"sum of (target - centre) along image {axis.upper()} / N, signed",
        reads=(f"error_{axis}_px",),
        compute=lambda window: exact_mean(window.values(f"error_{axis}_px")),
    )


def _circle_metric(radius_m: float) -> LevelMetric[Window]:
    return LevelMetric(
        name=f"in_{radius_m:g}_m_percent".replace("0.", "0_"),
        label=f"Time within {radius_m:g} m",
        unit="%",
        better="higher",
        formula=f"100 x control steps with d <= {radius_m:g} m / N",
        reads=("distance",),
        compute=lambda window: percent((window.values("distance") <= radius_m).tolist()),
    )


def _vrx(window: Window) -> float:
    pairs = zip(window.distance_m, window.heading_error.tolist(), strict=True)
    return mean([distance + VRX_BASE**distance * heading for distance, heading in pairs])


def _thrust_rms(window: Window) -> float:
    return math.sqrt(exact_mean((np.abs(window.thrust) * np.abs(window.thrust)).sum(axis=1)))


def _variation(window: Window) -> float:
    references = window.rows[:, INDEX["ref_u"] : INDEX["ref_w"] + 1]
    return exact_sum(np.abs(np.diff(references, axis=0)))


def _saturated(window: Window) -> float:
    forward, reverse = window.facts.limits_n
    full = (window.thrust >= FULL_THRUST * forward) | (window.thrust <= -FULL_THRUST * reverse)
    return float(full.any(axis=1).sum()) * window.dt


def _collisions(window: Window) -> float:
    """Return the number of contacts, where those less than `REBOUND_S` apart are one."""
    touched = np.flatnonzero(window.values("contact_n") > 0.0).tolist()
    apart = round(REBOUND_S / window.dt)
    starts = sum(1 for a, b in pairwise(touched) if b - a > apart)
    return float(starts + bool(touched))


def _contact_time(window: Window) -> float:
    return int(np.count_nonzero(window.values("contact_n") > 0.0)) * window.dt


METRICS: tuple[LevelMetric[Window], ...] = (
    *_distance_metrics("m", "d", "distance", "distance"),
    *_distance_metrics("px", "e", "distance in the image", "distance_px"),
    _mean_error_metric("x", "starboard"),
    _mean_error_metric("y", "aft"),
    *(_circle_metric(radius_m) for radius_m in CIRCLES_M),
    LevelMetric(
        name="iae_m_s",
        label="Integral of the absolute error",
        unit="m s",
        better="lower",
        formula="sum d dt",
        over=SUM,
        reads=("distance",),
        compute=lambda window: exact_sum(window.values("distance")) * window.dt,
    ),
    LevelMetric(
        name="ise_m2_s",
        label="Integral of the squared error",
        unit="m² s",
        better="lower",
        formula="sum d^2 dt",
        over=SUM,
        reads=("distance",),
        compute=lambda window: exact_sum(window.values("distance") ** 2) * window.dt,
    ),
    LevelMetric(
        name="itae_m_s2",
        label="Integral of time times absolute error",
        unit="m s²",
        better="lower",
        meaning="late errors cost more",
        formula="sum t d dt, t from the start of the window",
        over=SUM,
        reads=("distance",),
        compute=lambda window: (
            exact_sum(np.arange(len(window.rows)) * window.dt * window.values("distance"))
            * window.dt
        ),
    ),
    LevelMetric(
        name="heading_rmse_rad",
        label="RMSE of the heading",
        unit="rad",
        better="lower",
        formula="sqrt(sum (yaw - reference)^2 / N), the angle within -pi to pi",
        over=RMS,
        reads=("yaw",),
        compute=lambda window: exact_root_mean_square(window.heading_error),
    ),
    LevelMetric(
        name="vrx_m",
        label="VRX station-keeping error",
        unit="m",
        better="lower",
        meaning="distance plus weighted heading error, as in the VRX competition",
        formula=f"sum (d + {VRX_BASE:g}^d abs(yaw - reference)) / N, as in the VRX competition",
        reads=("distance", "yaw"),
        compute=_vrx,
    ),
    LevelMetric(
        name="thrust_rms_n",
        label="RMS thrust of all thrusters",
        unit="N",
        better="lower",
        formula="sqrt(sum over control steps and thrusters of thrust^2 / N)",
        over=RMS,
        reads=THRUST_COLUMNS,
        compute=_thrust_rms,
    ),
    ENERGY,
    LevelMetric(
        name="variation_m_s",
        label="Total variation of the references",
        unit="m/s",
        better="lower",
        meaning="sum of all changes: how restless the controller is",
        formula="sum of the absolute changes of the three velocity references",
        over=SUM,
        reads=("ref_u", "ref_v", "ref_w"),
        compute=_variation,
    ),
    LevelMetric(
        name="saturated_s",
        label="Time with a saturated thruster",
        unit="s",
        better="lower",
        formula=f"control steps with a thruster at {100.0 * FULL_THRUST:g} % of its limit or more, "
        "times dt",
        over=SUM,
        reads=THRUST_COLUMNS,
        compute=_saturated,
    ),
    LevelMetric(
        name="lost_percent",
        label="Time with the target lost",
        unit="%",
        better="lower",
        formula="100 x control steps at which the tracker reports a loss, or its corners are more "
        f"than {LOST_PX:g} px from the true ones / N",
        reads=LOST_COLUMNS,
        compute=lambda window: window.lost_percent,
    ),
    LevelMetric(
        name="collisions",
        label="Collisions",
        unit="",
        better="lower",
        meaning=f"contacts less than {REBOUND_S:g} s apart count as one",
        formula=f"number of contacts, those less than {REBOUND_S:g} s apart counted as one",
        over=SUM,
        reads=("contact_n",),
        compute=_collisions,
    ),
    LevelMetric(
        name="contact_s",
        label="Time in contact",
        unit="s",
        better="lower",
        formula="control steps with a contact force, times dt",
        over=SUM,
        reads=("contact_n",),
        compute=_contact_time,
    ),
    LevelMetric(
        # The peak of a blow within a control period depends on the stiffness of the hull, which is
        # not modelled.
        name="contact_max_n",
        label="Maximum contact force",
        unit="N",
        better="lower",
        meaning="the net force on the hull, mean over one control period",
        formula="maximum contact force, mean over a control period",
        over=MAX,
        reads=("contact_n",),
        compute=lambda window: _largest(window.values("contact_n")),
    ),
)
POINTS: LevelMetric[Level] = LevelMetric(
    name="points",
    label="Points of the level",
    unit="of 100",
    better="higher",
    meaning=f"100 / (1 + RMSE / {SCORE_LENGTH_M:g} m) x (1 - share of the time lost)",
    formula=f"100 / (1 + rmse_m / {SCORE_LENGTH_M:g} m) x (1 - {WHOLE}lost_percent / 100)",
    reads=("distance", *LOST_COLUMNS),
    compute=lambda level: points(
        exact_root_mean_square(_defined(level.settled.values("distance"))),
        level.whole.lost_percent / 100.0,
    ),
)
SETTLING: LevelMetric[Level] = LevelMetric(
    name="settling_s",
    label=f"Settling time to {SETTLED_M:g} m",
    unit="s",
    better="lower",
    meaning=f"time from the start of the level until the distance stays within {SETTLED_M:g} m",
    formula=f"first time from which d <= {SETTLED_M:g} m until the end; none if it ends outside",
    over=MAX,
    reads=("distance",),
    compute=lambda level: settling_time(level.whole.distance_m, level.whole.dt),
)
HELD = Metric(
    "held",
    "Held",
    "",
    "higher",
    meaning=f"95 % of the time within {HELD_P95_M:g} m, and the target never lost",
)
HEAD = (POINTS, HELD, SETTLING)
_KEY = ("rmse_m", "p95_m", "max_m", "rmse_px", "mean_x_px", "mean_y_px", "lost_percent")
KEY_METRICS = tuple(metric for metric in METRICS if metric.name in _KEY)
GROUP = MetricGroup("Position controllers", (POINTS, SETTLING, *METRICS))


def overall(metrics: Iterable[LevelMetric[Window]] = METRICS) -> tuple[LevelMetric[Any], ...]:
    """Return what there is over a whole run, given the metrics of a window."""
    whole = (replace(metric, name=f"{WHOLE}{metric.name}") for metric in metrics)
    return (POINTS, SETTLING, *metrics, *whole)


def level_metrics(
    rows: Rows, facts: LevelFacts, metrics: Iterable[LevelMetric[Window]] = METRICS
) -> dict[str, Any]:
    """Return the metrics of one level, name -> float (None where there is none)."""
    level, absent = Level(rows, facts), facts.absent
    return (
        {"level": facts.level, "speed": facts.speed}
        | compute_all(metrics, level.settled, absent=absent)
        | compute_all(metrics, level.whole, prefix=WHOLE, absent=absent)
        | compute_all((SETTLING, POINTS), level, absent=absent)
        | {"held": None if absent & set(POINTS.reads) else _held(level)}
    )


def _held(level: Level) -> bool:
    within = _p95(_defined(level.whole.values("distance"))) < HELD_P95_M
    return within and level.whole.lost_percent == 0.0
