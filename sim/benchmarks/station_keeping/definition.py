"""A station-keeping benchmark: everything but its name, settings and baselines."""

from collections.abc import Mapping
from pkgutil import resolve_name

from seamark.sim.benchmarks.benchmark import Baseline, Benchmark, Chart, Table
from seamark.sim.benchmarks.station_keeping.starting_points import HARDER
from seamark.sim.metrics.metric import LevelMetric, Metric, MetricGroup
from seamark.sim.metrics.station_keeping import GROUP, HEAD, KEY_METRICS, METRICS, WHOLE
from seamark.sim.metrics.windows import Window
from seamark.sim.recording.telemetry import thrust_names
from seamark.sim.registry import CONTROLLERS, REFERENCE_CONTROLLERS, VEHICLES
from seamark.sim.settings.station_keeping import StationKeepingSettings
from seamark.sim.vehicles import load, most_thrusters

CHARTS = (
    Chart("Distance to the target", "px", ("distance_px",)),
    Chart("X error", "px", ("error_x_px",)),
    Chart("Y error", "px", ("error_y_px",)),
    Chart("Distance to the station", "m", ("distance",)),
    Chart("Error as the controller sees it", "m", ("error_x", "error_y", "error_z")),
    Chart("Velocity reference", "m/s", ("ref_u", "ref_v", "ref_w")),
    Chart("Velocity by the DVL", "m/s", ("dvl_u", "dvl_v", "dvl_w")),
    Chart("Current", "m/s", ("current_x", "current_y", "current_z")),
    Chart("Tracker's error", "px", ("tracker_error",)),
    Chart("Thrust", "N", thrust_names(most_thrusters())),
    Chart("Contact force", "N", ("contact_n",)),
    Chart("Depth", "m", ("z",)),
    Chart("Attitude", "rad", ("roll", "pitch", "yaw")),
)
_BOARD = frozenset({"rmse_m", "p95_m", "heading_rmse_rad", "energy_n15_s", "lost_percent"})
GROUPS = (
    "Experiment",
    "Position controller",
    "Tracker",
    "Grid",
    "Current",
    "Water and camera",
    "Station keeper",
    "Velocity controller",
    "Sensors",
    "Faults",
)


def station_keeping_benchmark(
    *,
    name: str,
    title: str,
    summary: str,
    configuration: type[StationKeepingSettings],
    baselines: Mapping[str, Baseline],
    quick_settings: Mapping[str, object],
    metrics: tuple[LevelMetric[Window], ...] = (),
    experiment: str = "seamark.sim.benchmarks.station_keeping.experiment:EXPERIMENT",
) -> Benchmark:
    """Return a benchmark of position controllers.

    Parameters
    ----------
    metrics
        Further metrics; `experiment` then is the path of a `StationKeeping` that computes them.
    """
    further = tuple(metric for metric in METRICS if metric not in KEY_METRICS)
    return Benchmark(
        name=name,
        title=title,
        summary=summary,
        participants="position controllers",
        role="controller",
        built_in=_labels(CONTROLLERS),
        reference_built_in=_labels(REFERENCE_CONTROLLERS),
        experiment=experiment,
        headline=Metric("score", "Score", "of 100", "higher"),
        score_bar_max=100.0,
        level_held_unit="m/s",
        charts=CHARTS,
        tables=(
            Table("Each level as a whole", HEAD),
            Table("After the settle window of {settle_s:g} s", KEY_METRICS),
            Table("More metrics, after the settle window of {settle_s:g} s", (*further, *metrics)),
            Table("Whole levels", (*METRICS, *metrics), prefix=WHOLE),
        ),
        key_metrics=KEY_METRICS[:1],
        board_metrics=tuple(metric for metric in METRICS if metric.name in _BOARD),
        pareto=(_named("rmse_m"), _named("energy_n15_s")),
        metric_groups=(GROUP, *((MetricGroup(title, metrics),) if metrics else ())),
        baselines=baselines,
        configuration=configuration,
        groups=GROUPS,
        presets={
            "vehicle": {name: load(name).defaults for name in VEHICLES if load(name).defaults}
        },
        quick_settings=quick_settings,
        starting_points=HARDER,
    )


def _named(name: str) -> Metric:
    return next(metric for metric in METRICS if metric.name == name)


def _labels(controllers: Mapping[str, str]) -> dict[str, str]:
    """Return name -> label of controllers in the registry."""
    return {name: resolve_name(path).label for name, path in controllers.items()}
