"""visibility-v2: which tracker keeps its target in the most turbid water and the fastest motion.

Three axes, axis by axis and the most difficult level first. *Turbidity*: the optical depth
rises from 0 to 7 on one path, the same at all levels. *Motion*: another path in moderately clear
water is played faster and faster. *Jumps*: the tracker is started, and has one image to find a
target that was displaced. The score is the area under p@5 over the optical depth: a mean over
levels and trials, so that no unlucky level decides.
"""

from collections.abc import Callable, Mapping
from typing import Any

from seamark.sim.benchmarks.benchmark import (
    Baseline,
    Benchmark,
    Chart,
    Curve,
    Midpoint,
    RankedProtocol,
    StartingPoint,
    Table,
)
from seamark.sim.benchmarks.visibility_v1.definition import solution_label
from seamark.sim.benchmarks.visibility_v2.settings import (
    JUMP,
    MOTION,
    TURBIDITY,
    Axis,
    VisibilityConfiguration,
)
from seamark.sim.metrics.metric import Metric
from seamark.sim.metrics.tracking import FAILED_PERCENT, GROUP, HELD, P1, P5
from seamark.sim.metrics.tracking_losses import LOSS_GROUP, METRICS, followed_metrics, jump_metrics
from seamark.sim.recording.telemetry import Rows

SCORE = Metric(
    "turbidity_held",
    "Turbidity held",
    "optical depth",
    "higher",
    "area under p@5 over the optical depth: the mean depth at which the tracker loses its target",
)
MIDPOINT = Metric(
    "tau_midpoint",
    "τ midpoint",
    "optical depth",
    "higher",
    "optical depth at which a curve fitted to p@5 of all trials falls to half of its plateau",
)
MOTION_HELD = Metric(
    "motion_held_px",
    "Motion held",
    "px per image",
    "higher",
    "area under p@5 over the image motion, in moderately clear water",
)
BASIN = Metric(
    "basin_px",
    "Convergence basin",
    "px",
    "higher",
    "area under p@1 over the size of single jumps, in clear water",
)


# Of set-ups that cannot be told apart one is a mark: KCF is as good as the box tracker, MI as ZNCC,
# SSD and median flow no better than being blind (./run performance visibility_headroom).
MARKS = {
    "nothing": Baseline("Nothing: the corners of the start for ever", "nothing"),
    "blind": Baseline("Blind after four images: constant velocity", "blind"),
    "box": Baseline("Box tracker", "built-in", {"tracker": "box"}),
    "klt": Baseline("KLT, homography", "built-in", {"tracker": "klt", "warp": "homography"}),
    "ecc": Baseline("ECC, homography", "built-in", {"tracker": "ecc", "warp": "homography"}),
    "zncc-homography": Baseline(
        "Template tracker, ZNCC, homography",
        "built-in",
        {"criterion": "zncc", "warp": "homography"},
    ),
    "zncc-srt": Baseline(
        "Template tracker, ZNCC, SRT", "built-in", {"criterion": "zncc", "warp": "srt"}
    ),
    "mosse": Baseline("MOSSE", "built-in", {"tracker": "mosse"}),
    "oracle": Baseline("Oracle: the true corners", "oracle"),
}


def turbidity_point(level: Mapping[str, Any]) -> tuple[float, float] | None:
    """Return optical depth and p@5 of a level of the turbidity axis."""
    if level["axis"] != TURBIDITY.name:
        return None
    return float(level["value"]), 0.01 * float(level[P5.name])


def curve(
    axis: Axis,
    area: Metric,
    metrics: tuple[Metric, ...],
    measure: Callable[[Rows], Mapping[str, Any]],
) -> Curve:
    """Return the chart of one axis."""

    def levels(config: VisibilityConfiguration) -> tuple[int, ...]:
        return config.levels_of(axis)

    return Curve(
        metrics=metrics,
        limit=FAILED_PERCENT,
        values=VisibilityConfiguration.level_values,
        measure=measure,
        levels=levels,
        area=area,
        x_label=f"{axis.label} [{axis.unit}]" if axis.unit else axis.label,
    )


BENCHMARK = Benchmark(
    name="visibility-v2",
    title="Trackers in turbid water and fast motion",
    summary=(
        "Track a target that nobody has seen before, in water of rising turbidity, in ever faster "
        "motion, and after single jumps."
    ),
    question="Which tracker keeps its target in the most turbid water and the fastest motion?",
    participants="trackers",
    role="tracker",
    error_column="tracker_error",
    gym_family="VisualTracking",
    built_in={"built-in": "Built-in tracker"},
    experiment="seamark.sim.benchmarks.visibility_v2.experiment:EXPERIMENT",
    headline=SCORE,
    score_bar_max=7.0,
    level_held_unit="optical depth",
    charts=(
        Chart("Corner error", "px", ("tracker_error",)),
        Chart("The tracker reports the target", "1 = yes", ("tracker_ok",)),
        Chart("Image position of the target along X", "px", ("target_x", "tracked_x")),
        Chart("Image position of the target along Y", "px", ("target_y", "tracked_y")),
        Chart("Distance to the target", "px", ("distance_px",)),
        Chart("Velocity", "m/s", ("u", "v", "w")),
        Chart("Attitude", "rad", ("roll", "pitch", "yaw")),
    ),
    configuration=VisibilityConfiguration,
    groups=("Tracker", "Levels", "Motion", "Scene"),
    tables=(
        Table("Images of a level in which the tracker had to find the target", (*METRICS, HELD)),
    ),
    key_metrics=(P5,),
    metric_groups=(GROUP, LOSS_GROUP),
    overall=(MIDPOINT, MOTION_HELD, BASIN, *METRICS),
    overall_levels="turbidity levels",
    board_metrics=(MIDPOINT, MOTION_HELD, BASIN, *METRICS),
    curves=(
        curve(TURBIDITY, SCORE, (P5, P1), followed_metrics),
        curve(MOTION, MOTION_HELD, (P5, P1), followed_metrics),
        curve(JUMP, BASIN, (P1, P5), jump_metrics),
    ),
    midpoint=Midpoint(MIDPOINT, turbidity_point),
    solution_label=solution_label,
    quick_settings={
        "turbidity_levels": [0.0, 7.0],
        "motion_levels": [2.0, 8.0],
        "jump_levels": [2.0, 8.0],
        "level_duration_s": 2.0,
    },
    baselines=MARKS,
    starting_points={
        "klt": StartingPoint(
            "Optical flow",
            "Corners tracked by optical flow instead of a template.",
            {"tracker": "klt"},
        ),
        "ssd": StartingPoint(
            "Squared differences",
            "The template tracker compares grey levels directly, which changes of light disturb.",
            {"criterion": "ssd"},
        ),
        "turbid": StartingPoint(
            "Turbid water",
            "The motion axis runs in more turbid water.",
            {"motion_depth": 3.0},
        ),
    },
    reference_built_in={name: MARKS[name].title for name in ("nothing", "blind", "oracle")},
    scale=(0.42, 7.0),  # nothing: mean of 96 trials
    protocol=RankedProtocol(reference_trials=8, fresh_trials=24),
)
