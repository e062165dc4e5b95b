"""What the player of a run needs beside the run's own data, as JSON in the page."""

from collections.abc import Sequence
from typing import Any

from seamark.server.pages.run.log_view import (
    PIXELS,
    WHOLE,
    absent_columns,
    has_unknown_current,
    tracks,
)
from seamark.server.programs import own_files
from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.showing.maps import map_of
from seamark.server.runs.showing.views import RunView
from seamark.server.web import known_benchmarks
from seamark.server.web.services import services
from seamark.server.web.streams.excerpts import start_of_trial
from seamark.sim.benchmarks.benchmark import Chart
from seamark.sim.control.observation import SONAR
from seamark.sim.recording import telemetry
from seamark.sim.settings.configuration import Configuration
from seamark.sim.settings.experiment import ExperimentSettings
from seamark.sim.settings.grid import level_names

IMAGE_PERIOD_S = 0.05
_NOT_CHARTED = frozenset({"trial", "t"})  # the same in a whole chart, and its axis
# Those of a detector are hundreds, which make sense together: the camera shows them.
_DETECTIONS = frozenset(column.name for column in telemetry.DETECTION_COLUMNS)


def player_data(run: RunView, files: RunFiles) -> dict[str, Any]:
    """Return levels, charts and columns of a run."""
    benchmark = known_benchmarks.by_name(run.benchmark)
    config = benchmark.restore(run.config)
    with own_files.lent_to(services().settings, run):
        charts, unused = _charts(run, benchmark.charts_of(config)), config.unused_columns()
    width = _width(files, config)
    left_out = _NOT_CHARTED | absent_columns(run) | unused | _DETECTIONS
    return {
        "id": run.id,
        "benchmark": run.benchmark,
        "live": not run.state.final,
        "trials": run.trials,
        "trial_s": benchmark.trial_duration_s(config),
        "level_s": run.config.get("level_duration_s"),
        "levels": config.level_values(),
        "ordered": config.levels_in_order(),
        "names": (WHOLE,) if has_unknown_current(run) else level_names(config),
        "level": {"label": config.level_metric().label, "unit": config.level_metric().unit},
        "arm": telemetry.has_arm(width),
        "sonar": SONAR in config.cameras_of_program(),
        "detections": telemetry.has_detections(width),
        "map": map_of(telemetry.names(width)),
        "step_s": run.config.get("control_period_s", IMAGE_PERIOD_S),
        "charts": charts,
        "stages": benchmark.stage_labels,
        "before": benchmark.before_stages,
        "columns": [
            {"name": column.name, "unit": column.unit, "meaning": column.meaning}
            for column in telemetry.columns(width)
            if column.name not in left_out
        ],
        "api": f"/api/v1/runs/{run.id}",
        "events_after": str(start_of_trial(files)),
    }


def _width(files: RunFiles, config: Configuration) -> int:
    """Return how many columns the rows have, or will have: a live page wants them as they come."""
    if files.row_count():
        return len(files.columns)
    if not isinstance(config, ExperimentSettings):
        return config.telemetry_shape()[1]
    return config.telemetry_width(telemetry.COMMON_THRUSTERS)


def _charts(run: RunView, charts: Sequence[Chart]) -> list[dict[str, Any]]:
    """Return the charts of the columns that a run has; where no tracker saw it, none in pixels."""
    absent = absent_columns(run)
    shown = [
        {"title": chart.title, "unit": chart.unit, "columns": columns}
        for chart in charts
        if (columns := [name for name in chart.columns if name not in absent])
    ]
    return shown if tracks(run) else [chart for chart in shown if chart["unit"] != PIXELS]
