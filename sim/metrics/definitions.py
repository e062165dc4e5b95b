"""What every number in metrics.json is: for docs/measures.md and the pages, from one table.

d is the true distance of the camera from its station [m], e that of the target from the image
centre [px], T the length of the window, N its number of control ticks, dt the control period.
"""

from collections.abc import Iterable, Mapping

from seamark.sim.metrics import station_keeping, tracking, uwsim_metrics
from seamark.sim.metrics.metric import Metric

FORMULAS: Mapping[str, str] = {
    "points": "100 / (1 + rmse_m / 0.25 m) x (1 - whole_lost_percent / 100)",
    "settling_s": "first time from which d <= 0.1 m until the end; none if it ends outside",
    "rmse_m": "sqrt(sum d^2 / N)",
    "mae_m": "sum d / N",
    "p95_m": "value that d stays below for 95 % of the ticks, interpolated",
    "max_m": "max d",
    "rmse_px": "sqrt(sum e^2 / N)",
    "mae_px": "sum e / N",
    "p95_px": "value that e stays below for 95 % of the ticks, interpolated",
    "max_px": "max e",
    "mean_x_px": "sum of (target - centre) along image X / N, with its sign",
    "mean_y_px": "sum of (target - centre) along image Y / N, with its sign",
    "in_0_1_m_percent": "100 x ticks with d <= 0.1 m / N",
    "in_0_25_m_percent": "100 x ticks with d <= 0.25 m / N",
    "in_0_5_m_percent": "100 x ticks with d <= 0.5 m / N",
    "iae_m_s": "sum d dt",
    "ise_m2_s": "sum d^2 dt",
    "itae_m_s2": "sum t d dt, t from the start of the window",
    "heading_rmse_rad": "sqrt(sum (yaw - wanted)^2 / N), the angle within -pi to pi",
    "vrx_m": "sum (d + 0.75^d abs(yaw - wanted)) / N, as the VRX competition",
    "thrust_rms_n": "sqrt(sum over ticks and thrusters of thrust^2 / N)",
    "energy_n15_s": "sum over ticks and thrusters of abs(thrust)^1.5 dt",
    "variation_m_s": "sum of the sizes of all changes of the three velocity references",
    "saturated_s": "ticks with a thruster at 98 % of its limit or more, times dt",
    "lost_percent": "100 x ticks with the tracker's no, or its corners over 15 px from true / N",
    "collisions": "contacts, those less than 0.5 s apart counted as one",
    "contact_s": "ticks with a contact force, times dt",
    "contact_max_n": "greatest contact force, mean over a control period",
    "p5_percent": "100 x pictures with corners at most 5 px from the true ones / all but the first",
    "p1_percent": "the same with 1 px",
    "corner_px": "mean root of the mean square corner error of the pictures within 5 px",
    "admitted_percent": "100 x pictures in which the tracker says that it has lost / all",
    "not_admitted_percent": "100 x pictures over 10 px off without saying so / all",
    "time": "ticks times dt, simulated",
    "collision": "max(0, 1 - (contactSpeedMean + contactSpeedMax) / 0.5 m/s); 1 without contact",
    "contactTicks": "control ticks with a contact force",
    "contactSpeedMean": "mean speed over ground during them; 0 without any",
    "contactSpeedMax": "greatest speed over ground during them",
    "positionError": "mean distance from the place at which the level starts",
    "positionErrorX": "mean of its size along north",
    "positionErrorY": "mean of its size along east",
    "positionErrorZ": "mean of its size along down",
    "positionErrorAngle": "mean angle of the rotation from the attitude at which the level starts",
    "distance": "sum of the distances from tick to tick; a level's start is no part of it",
    "corners": "mean norm of all eight numbers of (tracked - true corners), ticks with a target",
    "centroid": "mean norm of (tracked - true centre), ticks with a target",
    "seenTicks": "control ticks in which the tracker says that it has the target",
    "objectCenteredOnCam": "mean distance of the true target from the image centre",
    "objectCenteredOnCamX": "mean of its size along image X",
    "objectCenteredOnCamY": "mean of its size along image Y",
    "pathFollowingIAE": "sum of the distance to the path, times dt",
    "pathFollowingISE": "sum of the squared distance to the path, times dt",
    "distanceToPath": "mean distance to the path",
}
OVER = {
    "mean": "mean of the levels",
    "rms": "root of the mean square of the levels",
    "sum": "sum of the levels",
    "max": "greatest of the levels",
}
TABLES: Mapping[str, tuple[Metric, ...]] = {
    "Position controllers": (
        station_keeping.POINTS,
        station_keeping.SETTLING,
        *station_keeping.METRICS,
    ),
    "Trackers": tracking.METRICS,
    "The original benchmark module": uwsim_metrics.MEASURES,
}
# measure of the original -> what is wrong with it, what is done here
ORIGINAL: Mapping[str, tuple[str, str]] = {
    "time": (
        "Wall time: a slow computer scores worse.",
        "Simulated time: time.",
    ),
    "collision": (
        "Reads the speed of one body twice where it means both (newer Bullet), so a hit by the "
        "other body counts as none.",
        "collision, from the speed of the vehicle; what it hits does not move.",
    ),
    "positionError": (
        "Total, axes and the quaternion's components, which are no angles and depend on the axis.",
        "positionError with its axes, and positionErrorAngle.",
    ),
    "distance": (
        "None known.",
        "distance; that the vehicle is put back at a level's start is no part of it.",
    ),
    "euclideanNorm": (
        "A failure counts as -1, which lowers the mean: a tracker that fails more scores better. "
        "The ViSP node publishes an upright rectangle for a turned target, the projected origin "
        "of the object is taken for its centre.",
        "corners and centroid over the ticks with a target only, their number as seenTicks; the "
        "true corners of the top face (the original's convention: target_truth=uwsim).",
    ),
    "objectCenteredOnCam": (
        "None known: it projects the true pose, so it is valid also out of view.",
        "objectCenteredOnCam, total and by axis.",
    ),
    "pathFollowing": (
        "What it calls ISE adds distance times dt: that is the IAE.",
        "pathFollowingIAE and a true pathFollowingISE. The path of a level is its station; for "
        "others, seamark.sim.metrics.uwsim_metrics.path_following takes any straight pieces.",
    ),
    "reconstruction3D": (
        "None known: mean error, variance, coverage and outliers by an occupancy grid.",
        "`sim/metrics/reconstruction.py`, on clouds. No benchmark uses it yet, as no run gives a "
        "point cloud.",
    ),
    "triggers": (
        "Compare squared distances with 0.2 and 0.3, which makes them 0.45 m and 0.55 m.",
        "No measure has a threshold that is not in its name or formula.",
    ),
}


def markdown() -> str:
    """Return all tables for docs/measures.md."""
    parts = [_table(title, entries) for title, entries in TABLES.items()]
    lines = [f"| {name} | {bad} | {ours} |" for name, (bad, ours) in ORIGINAL.items()]
    head = ["| original | what is wrong with it | here |", "|---|---|---|"]
    return "\n\n".join([*parts, "\n".join(["## Errors of the original", "", *head, *lines])])


def _table(title: str, entries: Iterable[Metric]) -> str:
    rows = [
        f"| `{entry.name}` | {entry.label} | {entry.unit or '-'} | {FORMULAS[entry.name]} "
        f"| {OVER[entry.over]} |"
        for entry in entries
    ]
    head = ["| name | meaning | unit | formula | over the run |", "|---|---|---|---|---|"]
    return "\n".join([f"## {title}", "", *head, *rows])
