"""Metrics of a level: what a run ends with, computed from its telemetry alone.

Every metric exists for the settled part of a level and, with the prefix `whole_`, for all of it.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seamark.sim.control.observation import THRUSTERS
from seamark.sim.metrics.metric import Metric
from seamark.sim.numerics.statistics import mean, percentile, root_mean_square
from seamark.sim.recording.telemetry import INDEX, Rows

SCORE_LENGTH_M = 0.25  # [m] RMSE at which a level gives half of its points
HELD_P95_M = (
    0.5  # [m] a level is held if 95 % of the time stays within, and the target is never lost
)
CIRCLES_M = (0.1, 0.25, 0.5)  # [m] watch circles
SETTLED_M = 0.1  # [m]
LOST_PX = 15.0  # [px] E: half of the target's shorter side at 2.27 m
FULL_THRUST = 0.98  # share of the limit from which a thruster counts as saturated; E
ENERGY_EXPONENT = 1.5  # ideal propeller: power grows with the thrust to the power of 1.5
REBOUND_S = 0.5  # S: ExperimentMeasurer, contacts closer than this are one collision
VRX_BASE = 0.75  # VRX StationkeepingScoringPlugin

METRICS: tuple[Metric, ...] = (
    Metric(
        "rmse_m",
        "RMSE of the distance",
        "m",
        "lower",
        "rms",
        meaning="root of the mean square: large errors weigh more",
    ),
    Metric("mae_m", "Mean distance", "m", "lower"),
    Metric(
        "p95_m",
        "Distance, 95th percentile",
        "m",
        "lower",
        "max",
        meaning="95 % of the time the distance is smaller",
    ),
    Metric("max_m", "Largest distance", "m", "lower", "max"),
    Metric("rmse_px", "RMSE of the distance in the picture", "px", "lower", "rms"),
    Metric("mae_px", "Mean distance in the picture", "px", "lower"),
    Metric("p95_px", "Distance in the picture, 95th percentile", "px", "lower", "max"),
    Metric("max_px", "Largest distance in the picture", "px", "lower", "max"),
    Metric(
        "mean_x_px",
        "Mean X error",
        "px",
        "lower",
        meaning="what a constant current leaves behind along image X (starboard)",
    ),
    Metric(
        "mean_y_px",
        "Mean Y error",
        "px",
        "lower",
        meaning="what a constant current leaves behind along image Y (aft)",
    ),
    Metric("in_0_1_m_percent", "Time within 0.1 m", "%", "higher"),
    Metric("in_0_25_m_percent", "Time within 0.25 m", "%", "higher"),
    Metric("in_0_5_m_percent", "Time within 0.5 m", "%", "higher"),
    Metric("iae_m_s", "Integral of the absolute error", "m s", "lower", "sum"),
    Metric("ise_m2_s", "Integral of the squared error", "m² s", "lower", "sum"),
    Metric(
        "itae_m_s2",
        "Integral of time times absolute error",
        "m s²",
        "lower",
        "sum",
        meaning="late errors cost more",
    ),
    Metric("heading_rmse_rad", "RMSE of the heading", "rad", "lower", "rms"),
    Metric(
        "vrx_m",
        "VRX station-keeping error",
        "m",
        "lower",
        meaning="distance plus weighted heading error, as in the VRX competition",
    ),
    Metric("thrust_rms_n", "RMS thrust of all thrusters", "N", "lower", "rms"),
    Metric(
        "energy_n15_s",
        "Energy proxy, integral of thrust^1.5",
        "N^1.5 s",
        "lower",
        "sum",
        meaning="an ideal propeller's power grows with thrust^1.5",
    ),
    Metric(
        "variation_m_s",
        "Total variation of the references",
        "m/s",
        "lower",
        "sum",
        meaning="sum of all changes: how restless the controller is",
    ),
    Metric("saturated_s", "Time with a thruster at its limit", "s", "lower", "sum"),
    Metric("lost_percent", "Time with the target lost", "%", "lower"),
    Metric(
        "collisions",
        "Collisions",
        "",
        "lower",
        "sum",
        meaning="contacts less than 0.5 s apart count as one",
    ),
    Metric("contact_s", "Time in contact", "s", "lower", "sum"),
    Metric(
        "contact_max_n",
        "Greatest contact force",
        "N",
        "lower",
        "max",
        meaning="the net force on the hull, mean over one control period",
    ),
)
SETTLING = Metric(
    "settling_s",
    "Settling time to 0.1 m",
    "s",
    "lower",
    "max",
    meaning="time from which the distance stays within 0.1 m",
)
POINTS = Metric(
    "points",
    "Points of the level",
    "of 100",
    "higher",
    meaning="100 / (1 + RMSE / 0.25 m) x (1 - share of the time lost)",
)
HELD = Metric(
    "held", "Held", "", "higher", meaning="95 % of the time within 0.5 m, and the target never lost"
)
HEAD = (POINTS, HELD, SETTLING)
WHOLE = "whole_"  # prefix of the metrics over a level's whole length
_FIRST = ("rmse_m", "p95_m", "max_m", "rmse_px", "mean_x_px", "mean_y_px", "lost_percent")
KEY_METRICS = tuple(metric for metric in METRICS if metric.name in _FIRST)
OVERALL = (  # what there is over a whole run
    POINTS,
    SETTLING,
    *METRICS,
    *(replace(metric, name=f"{WHOLE}{metric.name}") for metric in METRICS),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class LevelFacts:
    """What the metrics need beside the rows of one level."""

    level: int
    speed: float  # [m/s]
    dt: float  # [s]
    settle_s: float
    limits_n: tuple[float, float]  # greatest thrust forward, reverse
    heading: float = 0.0  # [rad] wanted


def level_metrics(rows: Rows, facts: LevelFacts) -> dict[str, Any]:
    """Return the metrics of one level, name -> float (None where there is none), and its points."""
    first = min(round(facts.settle_s / facts.dt), len(rows))
    settled = _window(rows[first:], facts)
    whole = _window(rows, facts)
    result: dict[str, Any] = {"level": facts.level, "speed": facts.speed}
    result |= settled | {f"{WHOLE}{name}": value for name, value in whole.items()}
    result["settling_s"] = settling_time(_column(rows, "distance"), facts.dt)
    result["points"] = points(settled["rmse_m"], whole["lost_percent"] / 100.0)
    result["held"] = bool(whole["p95_m"] < HELD_P95_M and whole["lost_percent"] == 0.0)
    return result


def points(rmse_m: float, lost_share: float) -> float:
    """Return the points of a level, 0 to 100: bounded, so one bad level costs at most its share."""
    return 100.0 / (1.0 + rmse_m / SCORE_LENGTH_M) * (1.0 - lost_share)


def settling_time(distance: Sequence[float], dt: float) -> float | None:
    """Return the time [s] from which the distance stays within 0.1 m; None if it does not."""
    last_outside = -1
    for at, value in enumerate(distance):
        if not value <= SETTLED_M:
            last_outside = at
    return None if last_outside == len(distance) - 1 else (last_outside + 1) * dt


def lost(rows: Rows) -> NDArray[np.bool_]:
    """Return at which rows the target is lost, (k,): by the tracker's word or by ground truth."""
    by_truth = ~(rows[:, INDEX["tracker_error"]] <= LOST_PX)  # nan counts as lost
    result: NDArray[np.bool_] = by_truth | (rows[:, INDEX["tracker_ok"]] == 0.0)
    return result


def _window(rows: Rows, facts: LevelFacts) -> dict[str, float]:
    return (
        _distances(rows)
        | _integrals(rows, facts.dt)
        | _headings(rows, facts)
        | _efforts(rows, facts)
        | {"lost_percent": _percent(lost(rows).tolist())}
        | _contacts(_column(rows, "contact_n"), facts.dt)
    )


def _distances(rows: Rows) -> dict[str, float]:
    result: dict[str, float] = {}
    for unit, name in (("m", "distance"), ("px", "distance_px")):
        values = _column(rows, name)
        if any(map(math.isnan, values)):
            values = [
                math.nan
            ]  # order statistics of nan would be nonsense that looks like a number
        result |= {
            f"rmse_{unit}": root_mean_square(values),
            f"mae_{unit}": mean(values),
            f"p95_{unit}": percentile(values, 0.95),
            f"max_{unit}": max(values, default=math.nan),
        }
    for axis in "xy":
        result[f"mean_{axis}_px"] = mean(_column(rows, f"error_{axis}_px"))
    distance = _column(rows, "distance")
    for radius in CIRCLES_M:
        name = f"in_{radius:g}_m_percent".replace("0.", "0_")
        result[name] = _percent([value <= radius for value in distance])
    return result


def _integrals(rows: Rows, dt: float) -> dict[str, float]:
    """Return IAE, ISE and ITAE; time counts from the window's start."""
    distance = _column(rows, "distance")
    return {
        "iae_m_s": math.fsum(distance) * dt,
        "ise_m2_s": math.fsum(value * value for value in distance) * dt,
        "itae_m_s2": math.fsum(at * dt * value for at, value in enumerate(distance)) * dt,
    }


def _headings(rows: Rows, facts: LevelFacts) -> dict[str, float]:
    turn = 2.0 * math.pi
    off = [abs((yaw - facts.heading + math.pi) % turn - math.pi) for yaw in _column(rows, "yaw")]
    distance = _column(rows, "distance")
    vrx = [d + VRX_BASE**d * h for d, h in zip(distance, off, strict=True)]
    return {"heading_rmse_rad": root_mean_square(off), "vrx_m": mean(vrx)}


def _efforts(rows: Rows, facts: LevelFacts) -> dict[str, float]:
    thrust = rows[:, INDEX["thrust_0"] : INDEX["thrust_0"] + THRUSTERS]
    size = np.abs(thrust)
    forward, reverse = facts.limits_n
    full = (thrust >= FULL_THRUST * forward) | (thrust <= -FULL_THRUST * reverse)
    references = rows[:, INDEX["ref_u"] : INDEX["ref_w"] + 1]
    squares = (size * size).sum(axis=1).tolist()
    return {
        "thrust_rms_n": math.sqrt(mean(squares)) if squares else math.nan,
        "energy_n15_s": math.fsum((size * np.sqrt(size)).ravel().tolist()) * facts.dt,
        "variation_m_s": math.fsum(np.abs(np.diff(references, axis=0)).ravel().tolist()),
        "saturated_s": float(full.any(axis=1).sum()) * facts.dt,
    }


def _contacts(forces: Sequence[float], dt: float) -> dict[str, float]:
    """Return how often, how long and how hard [N] the hull touched something.

    Contacts less than `REBOUND_S` apart are one collision. A force is the mean over a control
    period: what a blow peaks at within it depends on the hull's stiffness, which is not modelled.
    """
    touched = [at for at, force in enumerate(forces) if force > 0.0]
    apart = round(REBOUND_S / dt)
    starts = sum(1 for a, b in pairwise(touched) if b - a > apart)
    return {
        "collisions": float(starts + bool(touched)),
        "contact_s": len(touched) * dt,
        "contact_max_n": max(forces, default=math.nan),
    }


def _column(rows: Rows, name: str) -> list[float]:
    values: list[float] = rows[:, INDEX[name]].tolist()
    return values


def _percent(flags: Sequence[bool]) -> float:
    return 100.0 * sum(flags) / len(flags) if flags else math.nan


def over_run(levels: Sequence[Mapping[str, Any]]) -> dict[str, float | None]:
    """Return metrics over all levels of a trial from those of each level, which are equally long.

    Means, roots of mean squares, sums and maxima are those of all rows together. Only of the 95th
    percentiles it is the greatest. None where a level has none.
    """
    result: dict[str, float | None] = {}
    for metric in OVERALL:
        values = [level[metric.name] for level in levels]
        result[metric.name] = None if None in values else _OVER[metric.over](values)
    return result


_OVER: Mapping[str, Callable[[Sequence[float]], float]] = {
    "mean": mean,
    "rms": root_mean_square,
    "sum": math.fsum,
    "max": lambda values: math.nan if any(map(math.isnan, values)) else max(values),
}


def mean_over_trials(trials: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return the mean of each metric over trials, also of those within; None where one has none."""
    result: dict[str, Any] = {}
    for name, first in trials[0].items():
        values = [trial[name] for trial in trials]
        if isinstance(first, Mapping):
            result[name] = mean_over_trials(values)
        elif name == "held":
            result[name] = all(values)
        elif name == "level" or isinstance(first, str):
            result[name] = first
        else:
            none = any(value is None for value in values)
            result[name] = None if none else mean([float(value) for value in values])
    return result
