"""An intervention benchmark: everything but its name, settings, metrics and entries."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

from seamark.sim.benchmarks.arm_charts import ARM_CHARTS
from seamark.sim.benchmarks.benchmark import (
    Baseline,
    Benchmark,
    Chart,
    RankedProtocol,
    Stages,
    StartingPoint,
    Table,
)
from seamark.sim.metrics import attempts
from seamark.sim.metrics.metric import LevelMetric, Metric, MetricGroup
from seamark.sim.metrics.stages import HELD
from seamark.sim.recording.telemetry import thrust_names
from seamark.sim.settings.intervention import GROUPS, InterventionSettings
from seamark.sim.vehicles import most_thrusters

CHARTS = (
    Chart("Distance of the tool from the grip", "m", ("reach",)),
    Chart("Depth", "m", ("z", "tool_z", "workpiece_z")),
    Chart(
        "Forces on what is worked on, and on the hull",
        "N",
        ("work_push_n", "work_rest_n", "work_hull_n", "contact_n"),
    ),
    Chart("Grip: all contact of the arm with it", "N", ("work_arm_n",)),
    *ARM_CHARTS,
    Chart("Velocity reference", "m/s", ("ref_u", "ref_v", "ref_w")),
    Chart("Velocity by the DVL", "m/s", ("dvl_u", "dvl_v", "dvl_w")),
    Chart("Current", "m/s", ("current_x", "current_y", "current_z")),
    Chart("Tracker's error", "px", ("tracker_error",)),
    Chart("Thrust", "N", thrust_names(most_thrusters())),
    Chart("Attitude", "rad", ("roll", "pitch", "yaw")),
)


def intervention_benchmark(  # noqa: PLR0913  # one for each part that differs
    *,
    name: str,
    title: str,
    summary: str,
    question: str,
    configuration: type[InterventionSettings],
    metrics: Sequence[LevelMetric[Any]],
    metric_groups: tuple[MetricGroup, ...],
    stages: Stages,
    built_in: Mapping[str, str],
    reference_built_in: Mapping[str, str],
    scale: tuple[float, float],
    notes: Mapping[str, str] = MappingProxyType({}),
    marks: Mapping[str, Baseline] = MappingProxyType({}),
    parts: tuple[str, ...] = (),
    charts: tuple[Chart, ...] = (),
    groups: tuple[str, ...] = (),
) -> Benchmark:
    """Return a benchmark of programs that move an arm; its folder has the experiment.

    Each built-in solution is a baseline with its default settings. `metrics` are those of a level,
    the credit first, and `metric_groups` those of them that not every intervention has. `scale`
    goes from the score of doing nothing to that of the oracle. `notes` are those of baselines, and
    `marks` further ones, with settings of their own. `parts` are the roles of further programs,
    `charts` and `groups` what only it has.
    """
    credit, *rest = metrics
    return Benchmark(
        name=name,
        title=title,
        summary=summary,
        question=question,
        participants="programs",
        role="controller",
        parts=parts,
        moves_arm=True,
        built_in=built_in,
        reference_built_in=reference_built_in,
        experiment=f"seamark.sim.benchmarks.{name.replace('-', '_')}.experiment:EXPERIMENT",
        headline=Metric("score", "Done up to", "m/s", "higher"),
        scale=scale,
        score_bar_max=max(configuration.model_fields["levels"].default),
        level_held_unit="m/s",
        charts=(*CHARTS, *charts),
        tables=(Table("Each level", (*metrics, HELD)),),
        key_metrics=(credit,),
        board_metrics=tuple(metric for metric in rest if metric.unit),
        metric_groups=(attempts.GROUP, *metric_groups),
        stages=stages,
        baselines={
            **{
                key: Baseline(label, key, notes=notes.get(key, ""))
                for key, label in {**reference_built_in, **built_in}.items()
            },
            **marks,
        },
        configuration=configuration,
        groups=(*GROUPS[:4], *groups, *GROUPS[4:]),
        starting_points={
            "still-water": StartingPoint(
                "Still water", "One level without a current, to begin with.", {"levels": (0.0,)}
            ),
            "wrist-camera": StartingPoint(
                "Camera on the arm", "The program gets its images.", {"images": "arm"}
            ),
        },
        quick_settings={"levels": [0.1], "level_duration_s": 2.0},
        protocol=RankedProtocol(reference_trials=8, fresh_trials=24),
    )
