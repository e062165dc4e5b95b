"""The tables of docs/measures.md, generated from the declarations of the metrics.

`python -m seamark.sim.benchmarks.metrics_documentation` prints them.
"""

import sys
from collections.abc import Iterable, Mapping

from seamark.sim import registry
from seamark.sim.metrics import uwsim_metrics
from seamark.sim.metrics.metric import MetricGroup

# metric of the original module -> what is wrong with it, what is done here
ORIGINAL: Mapping[str, tuple[str, str]] = {
    "time": (
        "Wall time: a slow computer scores worse.",
        "Simulated time: `time`.",
    ),
    "collision": (
        "Reads the speed of one body twice where it means both (newer Bullet), so being hit by "
        "the other body does not count.",
        "`collision`, from the speed of the vehicle; the obstacles do not move.",
    ),
    "positionError": (
        "Total, axes and the quaternion's components, which are not angles and depend on the axis.",
        "`positionError` with its axes, and `positionErrorAngle`.",
    ),
    "distance": (
        "None known.",
        "`distance`; the reset of the vehicle at the start of a level does not count.",
    ),
    "euclideanNorm": (
        "A failure counts as -1, which lowers the mean: a tracker that fails more often scores "
        "better. The ViSP node publishes an upright rectangle for a rotated target and uses the "
        "projected origin of the object as its centre.",
        "`corners` and `centroid` over the control steps with a tracked target only, their number "
        "as `seenTicks`; the true corners of the top face (the original's convention: "
        "`target_truth=uwsim`).",
    ),
    "objectCenteredOnCam": (
        "None known: it projects the true pose, so it is valid out of view too.",
        "`objectCenteredOnCam`, total and by axis.",
    ),
    "pathFollowing": (
        "What it calls ISE adds distance times dt: that is the IAE.",
        "`pathFollowingIAE` and a true `pathFollowingISE`. The path of a level is its station, in "
        "`track-v1` the piece of the route that is due; "
        "`seamark.sim.metrics.uwsim_metrics.path_following` takes any polyline.",
    ),
    "reconstruction3D": (
        "None known: mean error, variance, coverage and outliers by an occupancy grid.",
        "`sim/metrics/reconstruction.py`, for point clouds. No benchmark uses it yet, as no run "
        "produces a point cloud.",
    ),
    "triggers": (
        "Compare squared distances with 0.2 and 0.3, which makes them 0.45 m and 0.55 m.",
        "Every threshold of a metric is in its name or formula.",
    ),
}


def metric_groups() -> tuple[MetricGroup, ...]:
    """Return the metrics of all benchmarks, each group once, and the original module's."""
    groups = (group for name in registry.BENCHMARKS for group in _groups_of(name))
    return tuple(dict.fromkeys((*groups, uwsim_metrics.GROUP)))


def _groups_of(benchmark: str) -> tuple[MetricGroup, ...]:
    return registry.benchmark(benchmark).metric_groups


def markdown(groups: Iterable[MetricGroup]) -> str:
    """Return the tables of the metrics, and that of the original module's errors."""
    rows = [f"| {name} | {wrong} | {here} |" for name, (wrong, here) in ORIGINAL.items()]
    head = ["## Errors of the original", "", "| original | what is wrong with it | here |"]
    errors = "\n".join([*head, "|---|---|---|", *rows])
    return "\n\n".join([*map(_table, groups), errors])


def _table(group: MetricGroup) -> str:
    rows = [
        f"| `{metric.name}` | {metric.label} | {metric.unit or '-'} | {metric.formula} "
        f"| {metric.over.description} |"
        for metric in group.metrics
    ]
    head = ["| name | meaning | unit | formula | over the run |", "|---|---|---|---|---|"]
    return "\n".join([f"## {group.title}", "", *head, *rows])


if __name__ == "__main__":
    sys.stdout.write(f"{markdown(metric_groups())}\n")
