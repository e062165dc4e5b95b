"""Adding a thing is one file or folder and one line of the registry.

Each test writes the files to a temporary folder, adds the line in a fresh interpreter, as the file
of the registry would have it, and runs a trial.
"""

import json
import os
import subprocess
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest

from seamark.sim.recording.telemetry import COMMON_THRUSTERS, WIDTH
from seamark.sim.vehicles import most_thrusters

START = """
import json, sys
from pathlib import PosixPath
from seamark.sim import registry
registry.{table}["{name}"] = {path!r}

from seamark.sim.benchmarks.metrics_documentation import markdown, metric_groups
from seamark.sim.registry import benchmark
properties = {{name: benchmark(name).schema()["properties"] for name in registry.BENCHMARKS}}
light = not {{"numba", "cv2", "pybullet"}} & set(sys.modules)
page = markdown(metric_groups())
registry.load_all()

from seamark.sim.engine.summary import summarise
from seamark.sim.engine.trial import run_trial
entry = benchmark("{benchmark}")
config = entry.read({{**entry.quick_settings, **json.loads({settings!r})}})
widths = []
solution = entry.load().built_in("{controller}", config)
result = run_trial(
    entry.name, config, solution, seed=3, trial=0, on_rows=lambda rows: widths.append(rows.shape[1])
)
print(json.dumps({{
    "properties": properties,
    "light": light,
    "page": page,
    "built_in": dict(entry.built_in),
    "charts": [chart.columns for chart in entry.charts_of(config)],
    "summary": summarise(entry.name, config, [result]),
    "width": widths[0],
}}))
"""
Added = Callable[..., dict[str, Any]]


@pytest.fixture
def added(tmp_path: Path) -> Added:
    """Adds one thing and returns what a trial with it, its form and its documentation give."""

    def add(
        table: str,
        name: str,
        path: str | Path,
        files: Mapping[str, str],
        *,
        benchmark: str = "currents-v1",
        controller: str = "pi",
        settings: Mapping[str, object] | None = None,
    ) -> dict[str, Any]:
        for file, text in files.items():
            tmp_path.joinpath(file).parent.mkdir(exist_ok=True)
            tmp_path.joinpath(file).write_text(text, encoding="utf-8")
        code = START.format(
            table=table,
            name=name,
            path=path,
            benchmark=benchmark,
            controller=controller,
            settings=json.dumps(settings or {}),
        )
        done = subprocess.run(
            [sys.executable, "-c", code],
            env={**os.environ, "PYTHONPATH": str(tmp_path)},
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        result: dict[str, Any] = json.loads(done.stdout)
        return result

    return add


HARBOUR = {
    "harbour_v1/__init__.py": "",
    "harbour_v1/metrics.py": """
from seamark.sim.metrics.metric import SUM, LevelMetric

OUTSIDE = LevelMetric(
    name="outside_s",
    label="Time outside 1 mm",
    unit="s",
    better="lower",
    formula="control steps with d > 1 mm, times dt",
    over=SUM,
    compute=lambda window: sum(d > 0.001 for d in window.distance_m) * window.dt,
)
""",
    "harbour_v1/definition.py": """
from harbour_v1.metrics import OUTSIDE
from seamark.sim.benchmarks.benchmark import Baseline
from seamark.sim.benchmarks.station_keeping.definition import station_keeping_benchmark
from seamark.sim.metrics.station_keeping import METRICS, overall
from seamark.sim.settings.custom_score import custom_score_setting
from seamark.sim.settings.setting import override
from seamark.sim.settings.station_keeping import StationKeepingSettings

INHERITED = StationKeepingSettings.model_fields


class HarbourSettings(StationKeepingSettings):
    levels: tuple[float, ...] = override(INHERITED["levels"], (0.05, 0.15))
    level_duration_s: float = override(INHERITED["level_duration_s"], 60.0)
    score: str = custom_score_setting(overall((*METRICS, OUTSIDE)), group="Experiment")


BENCHMARK = station_keeping_benchmark(
    name="harbour-v1",
    title="Station keeping in a harbour",
    summary="Keep station in a weak tide.",
    configuration=HarbourSettings,
    baselines={"p": Baseline("P", "p")},
    quick_settings={"level_duration_s": 2.0, "settle_s": 1.0},
    metrics=(OUTSIDE,),
    experiment="harbour_v1.experiment:EXPERIMENT",
)
""",
    "harbour_v1/experiment.py": """
from harbour_v1.metrics import OUTSIDE
from seamark.sim.benchmarks.station_keeping.experiment import StationKeeping

EXPERIMENT = StationKeeping((OUTSIDE,))
""",
}


@pytest.mark.slow
def test_a_second_station_keeping_benchmark_with_a_metric_is_one_folder(added: Added) -> None:
    result = added(
        "BENCHMARKS",
        "harbour-v1",
        "harbour_v1.definition:BENCHMARK",
        HARBOUR,
        benchmark="harbour-v1",
        settings={"score": "2 * whole_outside_s"},
    )

    summary, form = result["summary"], result["properties"]["harbour-v1"]
    first, second = summary["levels"]
    assert form["levels"]["default"] == [0.05, 0.15]
    assert form["levels"]["title"] == result["properties"]["currents-v1"]["levels"]["title"]
    assert result["light"]
    assert (first["speed"], second["speed"]) == (0.05, 0.15)
    assert 0 < first["whole_outside_s"] <= 2.0
    total = first["whole_outside_s"] + second["whole_outside_s"]
    assert summary["overall"]["whole_outside_s"] == pytest.approx(total)
    assert summary["own_score"]["value"] == pytest.approx(2 * total)
    assert "| `outside_s` | Time outside 1 mm | s | control steps with d > 1 mm" in result["page"]


DRIFTER = {
    "drifter/__init__.py": """
from seamark.sim.trackers.declaration import TrackerDeclaration, number_option
from seamark.sim.trackers.options import WARP


def unsupported(values):
    if values.get("warp") == "affine":
        return {"warp": "drifter does not support warp affine."}
    return {}


TRACKER = TrackerDeclaration(
    label="First corners, moved a little",
    path="drifter.tracker:Drifter",
    options=(
        WARP,
        number_option(
            "drift_px", 0.5, low=0, high=3, title="Drift", help="Per image.", unit="px"
        ),
    ),
    exact=False,
    unsupported=unsupported,
)
""",
    "drifter/tracker.py": """
import numba  # what a form must not load
from seamark.sim.trackers.interface import Track


class Drifter:
    def __init__(self, *, warp="homography", drift_px=0.5):
        self.drift_px = drift_px

    def start(self, image, corners):
        self.corners = corners.copy()

    def window(self):
        return 0, 0, 0, 0

    def update(self, image):
        self.corners = self.corners + self.drift_px
        return Track(self.corners, True, 0.0, 1)
""",
}


@pytest.mark.slow
def test_a_tracker_with_an_option_is_one_folder(added: Added) -> None:
    result = added(
        "TRACKERS",
        "drifter",
        "drifter:TRACKER",
        DRIFTER,
        benchmark="visibility-v1",
        controller="built-in",
        settings={"tracker": "drifter", "drift_px": 2.0, "path_swing_m": 0, "path_turn_rad": 0},
    )

    with_tracker = [form for form in result["properties"].values() if "tracker" in form]
    assert len(with_tracker) > 1
    for form in with_tracker:
        assert form["drift_px"]["x-applies"] == {"tracker": ["drifter"]}
        assert (form["drift_px"]["maximum"], form["drift_px"]["x-unit"]) == (3, "px")
        assert "drifter" in form["warp"]["x-applies"]["tracker"]
        label = form["tracker"]["x-labels"]["drifter"]
        assert label == "First corners, moved a little; not bit-identical on all processors"
    assert result["light"]
    assert result["summary"]["levels"][0]["p5_percent"] < 10.0


VEHICLE = """
format = 1
name = "other"
title = "Girona with {count} thrusters"
summary = "A further one."
extends = "girona500"
"""
THRUSTER = """
[[thrusters]]
name = "{name}"
position = {{ value = [0.0, {y}, 0.0], unit = "m", tag = "E", reason = "a test" }}
direction = {direction}
"""
FIVE = {"port": (-0.3, [1, 0, 0]), "starboard": (0.3, [1, 0, 0]), "bow": (0, [0, 0, 1]),
        "stern": (0, [0, 0, 1]), "sway": (0, [0, 1, 0])}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("count", [6, 11])
def test_a_vehicle_with_any_number_of_thrusters_is_one_file(
    added: Added, tmp_path: Path, count: int
) -> None:
    further = {f"further {number}": FIVE["sway"] for number in range(count - 5)}
    thrusters = [
        THRUSTER.format(name=name, y=y, direction=direction)
        for name, (y, direction) in {**FIVE, **further}.items()
    ]

    result = added(
        "VEHICLES",
        "other",
        tmp_path / "other.toml",
        {"other.toml": VEHICLE.format(count=count) + "".join(thrusters)},
        settings={"vehicle": "other", "tracker": "truth", "fault_thruster": count - 1},
    )

    thrusts = [column for chart in result["charts"] for column in chart if "thrust" in column]
    form = result["properties"]["currents-v1"]
    assert form["vehicle"]["x-labels"]["other"] == f"Girona with {count} thrusters"
    assert form["fault_thruster"]["maximum"] == max(count, most_thrusters()) - 1
    assert thrusts == [f"thrust_{i}" for i in range(count)]
    assert result["width"] == WIDTH + max(count - COMMON_THRUSTERS, 0)
    assert result["summary"]["levels"][0]["whole_max_m"] < 1.0


@pytest.mark.slow
def test_a_controller_is_one_file(added: Added) -> None:
    controller = """
class Controller:
    label = "Full ahead"

    def __init__(self, config):
        self.limit = config["reference_limit_m_s"]

    def reset(self, level):
        pass

    def step(self, observation):
        return [self.limit, 0.0, 0.0, 0.0]
"""

    result = added(
        "CONTROLLERS",
        "ahead",
        "ahead:Controller",
        {"ahead.py": controller},
        controller="ahead",
        settings={"tracker": "truth"},
    )

    assert result["built_in"]["ahead"] == "Full ahead"
    assert result["summary"]["levels"][0]["whole_max_m"] > 0.3
