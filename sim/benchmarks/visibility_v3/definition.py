"""visibility-v3: which tracker keeps a target that moves over the bottom by itself.

The three axes are those of visibility-v2: turbidity, motion and single jumps. But the target moves
over the bottom, so the bottom does not tell where it is; a wrong answer costs as much as a right
one gains, and an admitted loss costs nothing; and the water becomes so turbid that even an observer
loses the target that knows everything but its place.
"""

from dataclasses import replace
from functools import partial

from seamark.sim.benchmarks.benchmark import Baseline, StartingPoint, Table
from seamark.sim.benchmarks.visibility_v2 import definition as second
from seamark.sim.benchmarks.visibility_v2.definition import BASIN, MIDPOINT, curve
from seamark.sim.benchmarks.visibility_v2.settings import JUMP, MOTION, TURBIDITY
from seamark.sim.benchmarks.visibility_v3.settings import VisibilityConfiguration
from seamark.sim.metrics.metric import Metric
from seamark.sim.metrics.tracking import GROUP, HELD, P1, P5
from seamark.sim.metrics.tracking_answers import ANSWER_GROUP, METRICS, NET
from seamark.sim.metrics.tracking_losses import LOSS_GROUP, followed_metrics, jump_metrics

SCORE = Metric(
    "turbidity_held",
    "Turbidity held",
    "optical depth",
    "higher",
    "area under right less wrong answers over the optical depth",
)
MOTION_HELD = Metric(
    "motion_held_px",
    "Motion held",
    "px per image",
    "higher",
    "area under right less wrong answers over the image motion, in moderately clear water",
)
MARKS = {
    "nothing": Baseline("Nothing: the corners of the start for ever", "nothing"),
    "silent": Baseline("Silent: reports a loss in every image", "silent"),
    "blind": Baseline("Blind after four images: constant velocity", "blind"),
    "match": Baseline("Whole image: match of its middle", "whole-image-match"),
    "filter": Baseline("Whole image: correlation filter", "whole-image-filter"),
    "box": Baseline("Box tracker", "built-in", {"tracker": "box"}),
    "zncc-homography": Baseline(
        "Template tracker, ZNCC, homography",
        "built-in",
        {"criterion": "zncc", "warp": "homography"},
    ),
    "zncc-srt": Baseline(
        "Template tracker, ZNCC, SRT", "built-in", {"criterion": "zncc", "warp": "srt"}
    ),
    "mosse": Baseline("MOSSE", "built-in", {"tracker": "mosse"}),
    "ideal": Baseline("Ideal observer: knows all but the place", "ideal"),
    "oracle": Baseline("Oracle: the true corners", "oracle"),
}
_FOLLOWED = partial(followed_metrics, metrics=METRICS)
_JUMPED = partial(jump_metrics, metrics=METRICS)

BENCHMARK = replace(
    second.BENCHMARK,
    name="visibility-v3",
    title="Trackers of a moving target in turbid water",
    summary=(
        "Track a target that moves over the bottom, in water of rising turbidity, in ever faster "
        "motion, and after single jumps. A wrong answer costs more than an admitted loss."
    ),
    question="Which tracker keeps a moving target in the most turbid water and the fastest motion?",
    experiment="seamark.sim.benchmarks.visibility_v3.experiment:EXPERIMENT",
    headline=SCORE,
    score_bar_max=9.0,
    configuration=VisibilityConfiguration,
    tables=(
        Table("Images of a level in which the tracker had to find the target", (*METRICS, HELD)),
    ),
    key_metrics=(NET, P5),
    metric_groups=(GROUP, LOSS_GROUP, ANSWER_GROUP),
    overall=(MIDPOINT, MOTION_HELD, BASIN, *METRICS),
    board_metrics=(MIDPOINT, MOTION_HELD, BASIN, *METRICS),
    curves=(
        curve(TURBIDITY, SCORE, (NET, P5), _FOLLOWED),
        curve(MOTION, MOTION_HELD, (NET, P5), _FOLLOWED),
        curve(JUMP, BASIN, (P1, P5), _JUMPED),
    ),
    quick_settings={**second.BENCHMARK.quick_settings, "turbidity_levels": [0.0, 9.0]},
    baselines=MARKS,
    starting_points={
        **second.BENCHMARK.starting_points,
        "still": StartingPoint(
            "Standing target",
            "The target stands on the bottom, as in visibility-v2.",
            {"target_swing_m": 0.0, "target_turn_rad": 0.0},
        ),
    },
    reference_built_in={
        mark.built_in: mark.title for mark in MARKS.values() if mark.built_in != "built-in"
    },
    scale=(0.0, 9.0),  # a tracker that only reports losses, and the oracle
)
