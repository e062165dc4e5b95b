"""Metrics of a tool that the vehicle carries: how well it is held over a point, and at what cost.

The tool point is `TOOL_AHEAD_M` ahead of the camera and moves with the body, so that an error of
heading displaces it as well. In the formulas s is its true distance [m] from where it should be.
"""

import math
from collections.abc import Sequence

import numpy as np

from seamark.sim.metrics.energy import POWER, power_share
from seamark.sim.metrics.metric import RMS, LevelMetric, Metric, MetricGroup
from seamark.sim.metrics.windows import (
    LOST_COLUMNS,
    THRUST_COLUMNS,
    LevelFacts,
    Window,
    lost,
    percent,
)
from seamark.sim.numerics.statistics import percentile, root_mean_square
from seamark.sim.recording.telemetry import POSE_COLUMNS, Rows

TOOL_AHEAD_M = 1.0  # [m] E: reach of a manipulator
# E: from what a gripper on a soft object tolerates down to a valve's; each about 1.6 times the next
CIRCLES_M = (0.5, 0.32, 0.2, 0.125, 0.08, 0.05, 0.032, 0.02)
POWER_WEIGHT = 0.1  # quality that full thrust costs; E: small, it breaks ties
HELD_QUALITY = 0.5  # from which a level counts as held
REACHED_M = 0.1  # [m]


class ToolWindow(Window):
    """The rows of a level, and the distance of the tool point from where it should be, (N,) [m]."""

    def __init__(self, rows: Rows, facts: LevelFacts, error_m: list[float]) -> None:
        super().__init__(rows, facts)
        self.error_m = error_m


def in_circles(errors: Sequence[float], lost_rows: Sequence[bool]) -> float:
    """Return the share of the time, 0 to 1, within each of the watch circles, averaged."""
    seen = np.array(errors)[~np.array(lost_rows, bool)]
    hits = sum(int(np.count_nonzero(seen <= radius)) for radius in CIRCLES_M)
    return hits / (len(errors) * len(CIRCLES_M)) if errors else math.nan


def _quality(window: ToolWindow) -> float:
    held = in_circles(window.error_m, lost(window.rows).tolist())
    return held * (1.0 - POWER_WEIGHT * power_share(window))


def _near_percent(window: ToolWindow) -> float:
    gone = lost(window.rows).tolist()
    nearest = map(min, window.error_m, window.distance_m)
    limit = CIRCLES_M[0]
    return percent([s <= limit and not out for s, out in zip(nearest, gone, strict=True)])


def _transient(window: ToolWindow) -> float:
    errors = window.error_m
    reached = next((at for at, error in enumerate(errors) if error <= REACHED_M), len(errors))
    return reached * window.dt


QUALITY: LevelMetric[ToolWindow] = LevelMetric(
    name="quality",
    label="Quality",
    unit="",
    better="higher",
    meaning="share of the time in the watch circles, less a little for the power",
    formula="mean over the radii "
    + ", ".join(f"{radius:g}" for radius in CIRCLES_M)
    + " m of the share of the control steps with s within the radius and the target not lost, "
    f"times (1 - {POWER_WEIGHT:g} power_share)",
    reads=(*POSE_COLUMNS, *THRUST_COLUMNS, *LOST_COLUMNS),
    compute=_quality,
)
TRANSIENT: LevelMetric[ToolWindow] = LevelMetric(
    name="transient_s",
    label=f"Time until the tool is within {REACHED_M:g} m",
    unit="s",
    better="lower",
    formula=f"first time with s <= {REACHED_M:g} m; the whole level if there is none",
    reads=POSE_COLUMNS,
    compute=_transient,
)
NEAR: LevelMetric[ToolWindow] = LevelMetric(
    name="near_percent",
    label=f"Time within {CIRCLES_M[0]:g} m",
    unit="%",
    better="higher",
    meaning="of the tool or of the camera, with the target in view",
    formula=f"100 x control steps with s or d <= {CIRCLES_M[0]:g} m and the target not lost / N, d "
    "the distance of the camera from its station",
    reads=(*POSE_COLUMNS, "distance", *LOST_COLUMNS),
    compute=_near_percent,
)
METRICS: tuple[LevelMetric[ToolWindow], ...] = (
    QUALITY,
    LevelMetric(
        name="tool_rmse_m",
        label="RMSE of the tool point",
        unit="m",
        better="lower",
        formula="sqrt(sum s^2 / N)",
        over=RMS,
        reads=POSE_COLUMNS,
        compute=lambda window: root_mean_square(window.error_m),
    ),
    LevelMetric(
        name="tool_p95_m",
        label="95th percentile of the tool's error",
        unit="m",
        better="lower",
        formula="95th percentile of s over the control steps, interpolated",
        reads=POSE_COLUMNS,
        compute=lambda window: percentile(window.error_m, 0.95),
    ),
    TRANSIENT,
    POWER,
    NEAR,
)
HELD = Metric("held", "Held", "", "higher", meaning=f"quality of at least {HELD_QUALITY:g}")
GROUP = MetricGroup("Tool point, whole levels", METRICS)
