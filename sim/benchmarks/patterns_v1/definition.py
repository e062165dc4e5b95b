"""patterns-v1: which detector recognises objects among decoys in the most turbid water.

A camera passes over a sea bottom with one object of each class, among decoys that look alike. Each
level has another optical depth and another bottom, on which everything is drawn anew: size, form,
colour, lettering and code, burial, growth, light, particles. The score is the area under average
precision over the optical depth.
"""

from collections.abc import Mapping

from seamark.sim.benchmarks.benchmark import (
    Baseline,
    Benchmark,
    Chart,
    Curve,
    RankedProtocol,
    StartingPoint,
    Table,
)
from seamark.sim.benchmarks.patterns_v1.settings import PatternsConfiguration
from seamark.sim.detectors import network
from seamark.sim.metrics.metric import Metric
from seamark.sim.metrics.recognition import (
    AP,
    CLASS_GROUP,
    F_MEASURE,
    GROUP,
    HELD,
    HELD_PERCENT,
    MARKER_GROUP,
    METRICS,
    curve_metrics,
)

SCORE = Metric(
    "patterns_held",
    "Patterns recognised",
    "optical depth",
    "higher",
    "area under average precision over the optical depth: the mean depth at which objects are "
    "no longer recognised",
)

MARKS = {
    "nothing": Baseline("Nothing: no answer at all", "nothing"),
    "random": Baseline("Random boxes", "random"),
    "orb": Baseline("ORB features", "built-in", {"detector": "orb"}),
    "markers": Baseline("ArUco and AprilTag", "built-in", {"detector": "markers"}),
    "template": Baseline("Template matching", "built-in", {"detector": "template"}),
    "network": Baseline("Learned network", "network", notes=network.notes()),
    "oracle": Baseline("Oracle: the true corners", "oracle"),
}


def solution_label(config: Mapping[str, object]) -> str:
    """Return the name of a built-in detector."""
    return str(config.get("detector", ""))


BENCHMARK = Benchmark(
    name="patterns-v1",
    title="Patterns in turbid water",
    summary=(
        "Recognise a box, an amphora, a pipe, a panel, a connector, an anode and two kinds of "
        "markers among decoys on a sea bottom, in water of rising turbidity."
    ),
    question="Which detector recognises objects among decoys in the most turbid water?",
    participants="detectors",
    role="detector",
    error_column=None,
    built_in={"built-in": "Built-in detector"},
    solution_label=solution_label,
    experiment="seamark.sim.benchmarks.patterns_v1.experiment:EXPERIMENT",
    headline=SCORE,
    score_bar_max=6.0,
    level_held_unit="optical depth",
    charts=(
        Chart("Velocity", "m/s", ("u", "v", "w")),
        Chart("Attitude", "rad", ("roll", "pitch", "yaw")),
    ),
    configuration=PatternsConfiguration,
    groups=("Detector", "Levels", "Passage", "Scene"),
    tables=(
        Table("Recognition", (*GROUP.metrics, HELD)),
        Table("Average precision of each class", CLASS_GROUP.metrics),
        Table("Markers found, after Cesar et al. 2015", MARKER_GROUP.metrics),
    ),
    key_metrics=(AP, F_MEASURE),
    metric_groups=(GROUP, CLASS_GROUP, MARKER_GROUP),
    overall=METRICS,
    board_metrics=GROUP.metrics,
    curves=(
        Curve(
            metrics=(AP,),
            limit=HELD_PERCENT,
            values=PatternsConfiguration.level_values,
            measure=curve_metrics,
            area=SCORE,
            x_label="Optical depth",
        ),
    ),
    quick_settings={"optical_depths": [0.0, 6.0], "level_duration_s": 2.0},
    baselines=MARKS,
    starting_points={
        "colour": StartingPoint(
            "Colour images",
            "The program gets colour images instead of grey ones.",
            {"colour": True},
        ),
        "free": StartingPoint(
            "Nothing buried", "All things lie free on the bottom.", {"burial": 0.0}
        ),
    },
    reference_built_in={
        name: MARKS[name].title for name in ("nothing", "random", "network", "oracle")
    },
    scale=(0.0, 6.0),  # ./run performance patterns_headroom
    protocol=RankedProtocol(reference_trials=8, fresh_trials=24),
)
