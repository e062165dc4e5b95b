"""visibility-v1: which tracker keeps its target longest while the water gets worse.

Levels of 5 s. At the start of each the tracker is initialised with an image in the water of the
first level (clear water, by default) and the true corners in it; from the next image on it sees the
water of the level. So a level measures what a tracker that knows its target can do in that water,
independent of earlier levels. By default the optical depth tau = c Z rises from 0 to 7 in steps of
0.25; at the end e^-7 of the contrast is left, a tenth of a grey level.
"""

from collections.abc import Mapping

from seamark.sim.benchmarks.benchmark import Baseline, Benchmark, Chart, Curve, StartingPoint, Table
from seamark.sim.benchmarks.visibility_v1.settings import SWEEP_PRESETS, VisibilityConfiguration
from seamark.sim.metrics.metric import Metric
from seamark.sim.metrics.tracking import (
    FAILED_PERCENT,
    GROUP,
    HELD,
    LOSS_GROUP,
    METRICS,
    level_metrics,
)
from seamark.sim.trackers import option_names


def solution_label(config: Mapping[str, object]) -> str:
    """Return a short name of a built-in tracker with its options, such as "esm zncc srt"."""
    tracker = str(config.get("tracker", ""))
    options = option_names(tracker)
    chosen = (str(config.get(name, "")) for name in ("criterion", "warp") if name in options)
    return " ".join((tracker, *chosen))


OPTICAL_DEPTH = Metric("optical_depth", "Optical depth", "", "higher")
# Built-in trackers on the leaderboard: criterion, warp.
RANKED_TRACKERS = (
    ("zncc", "homography"),
    ("zncc", "affine"),
    ("zncc", "srt"),
    ("zncc", "translation"),
    ("mi", "homography"),
    ("mi", "srt"),
    ("ssd", "homography"),
)
_ABBREVIATIONS = {"srt": "SRT"}  # scale, rotation, translation

BENCHMARK = Benchmark(
    name="visibility-v1",
    title="Trackers in increasingly turbid water",
    summary=(
        "Track a box in the camera image while the optical depth of the water rises from 0 to 7, "
        "5 s per level, until the tracker fails."
    ),
    question="Which tracker keeps its target longest while the water gets worse?",
    participants="trackers",
    role="tracker",
    error_column="tracker_error",
    gym_family="VisualTracking",
    built_in={"built-in": "Built-in tracker"},
    experiment="seamark.sim.benchmarks.visibility_v1.experiment:EXPERIMENT",
    headline=Metric("tau50", "τ50", "optical depth", "higher"),
    score_bar_max=7.25,
    level_held_unit="optical depth",
    charts=(
        Chart("Corner error", "px", ("tracker_error",)),
        Chart("The tracker reports the target", "1 = yes", ("tracker_ok",)),
        Chart("Image position of the target along X", "px", ("target_x", "tracked_x")),
        Chart("Image position of the target along Y", "px", ("target_y", "tracked_y")),
        Chart("Distance to the target", "px", ("distance_px",)),
        Chart("Distance to the station", "m", ("distance",)),
        Chart("Velocity", "m/s", ("u", "v", "w")),
        Chart("Velocity reference", "m/s", ("ref_u", "ref_v", "ref_w")),
        Chart("Current", "m/s", ("current_x", "current_y", "current_z")),
        Chart("Depth", "m", ("z",)),
        Chart("Attitude", "rad", ("roll", "pitch", "yaw")),
    ),
    configuration=VisibilityConfiguration,
    groups=(
        "Tracker",
        "Sweep",
        "Experiment",
        "Motion",
        "Water and camera",
        "Position controller",
        "Station keeper",
        "Velocity controller",
        "Sensors",
        "Faults",
    ),
    tables=(Table("All images of a level but the first", (OPTICAL_DEPTH, *METRICS, HELD)),),
    curves=(
        Curve(
            metrics=METRICS[:2],
            limit=FAILED_PERCENT,
            values=VisibilityConfiguration.score_values,
            measure=level_metrics,
        ),
    ),
    key_metrics=METRICS[:1],
    metric_groups=(GROUP, LOSS_GROUP),
    overall=METRICS,
    board_metrics=METRICS,
    baselines={
        f"{criterion}-{warp}": Baseline(
            f"Template tracker, {criterion.upper()}, {_ABBREVIATIONS.get(warp, warp)}",
            "built-in",
            {"criterion": criterion, "warp": warp},
        )
        for criterion, warp in RANKED_TRACKERS
    },
    solution_label=solution_label,
    presets={"sweep": SWEEP_PRESETS},
    starting_points={
        "paper-fog": StartingPoint(
            "Paper's fog",
            "The published experiment: the fog of UWSim becomes denser from level to level.",
            {"sweep": "fog"},
        ),
        "light": StartingPoint(
            "Fading light", "The light decreases from level to level.", {"sweep": "light"}
        ),
        "klt": StartingPoint(
            "Optical flow",
            "Corners tracked by optical flow instead of a template.",
            {"tracker": "klt"},
        ),
        "closed-loop": StartingPoint(
            "Closed loop",
            "The vehicle keeps station by what the tracker reports, instead of following a path.",
            {"mode": "free"},
        ),
        "bluerov2": StartingPoint(
            "BlueROV2",
            "The BlueROV2 Heavy keeps station by what the tracker reports.",
            {"mode": "free", "vehicle": "bluerov2-heavy"},
        ),
    },
    quick_settings={"sweep_to": 0.25, "level_duration_s": 2.0},
)
