"""Adding a thing is one file or folder and one line of the registry.

The files are written to a temporary folder, and a fresh interpreter adds the lines, as the file of
the registry would have them, and runs a trial with each thing.
"""

import json
import os
import subprocess
import sys
from typing import Any

import pytest

from seamark.sim.recording.telemetry import COMMON_THRUSTERS, WIDTH
from seamark.sim.vehicles import most_thrusters

pytestmark = pytest.mark.slow

START = """
import json, sys
from pathlib import Path
from seamark.sim import registry

folder, trials = Path(sys.argv[1]), json.loads(sys.argv[2])
registry.BENCHMARKS["harbour-v1"] = "harbour_v1.definition:BENCHMARK"
registry.TRACKERS["drifter"] = "drifter:TRACKER"
registry.CONTROLLERS["ahead"] = "ahead:Controller"
registry.VEHICLES |= {name: folder / f"{name}.toml" for name in ("six", "eleven")}

from seamark.sim.benchmarks.metrics_documentation import markdown, metric_groups
from seamark.sim.registry import benchmark
properties = {name: benchmark(name).schema()["properties"] for name in registry.BENCHMARKS}
light = not {"numba", "cv2", "pybullet"} & set(sys.modules)
page = markdown(metric_groups())
registry.load_all()

from seamark.sim.engine.summary import summarise
from seamark.sim.engine.trial import run_trial

def ran(name, controller, settings):
    entry, widths = benchmark(name), []
    config = entry.read({**entry.quick_settings, **settings})
    solution = entry.load().built_in(controller, config)
    result = run_trial(
        name, config, solution, seed=3, trial=0, on_rows=lambda rows: widths.append(rows.shape[1])
    )
    return {
        "built_in": dict(entry.built_in),
        "charts": [chart.columns for chart in entry.charts_of(config)],
        "summary": summarise(name, config, [result]),
        "width": widths[0],
    }

ended = {thing: ran(*trial) for thing, trial in trials.items()}
print(json.dumps({"properties": properties, "light": light, "page": page, "trials": ended}))
"""
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


VEHICLE = """
format = 1
name = "{name}"
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


AHEAD = """
class Controller:
    label = "Full ahead"

    def __init__(self, config):
        self.limit = config["reference_limit_m_s"]

    def reset(self, level):
        pass

    def step(self, observation):
        return [self.limit, 0.0, 0.0, 0.0]
"""
COUNTS = {"six": 6, "eleven": 11}  # name of a vehicle -> its thrusters
STILL = {"tracker": "truth"}
TRIALS = {  # thing -> benchmark, controller and settings of its trial
    "harbour": ("harbour-v1", "pi", {"score": "2 * whole_outside_s"}),
    "drifter": (
        "visibility-v1",
        "built-in",
        {"tracker": "drifter", "drift_px": 2.0, "path_swing_m": 0, "path_turn_rad": 0},
    ),
    **{
        name: ("currents-v1", "pi", STILL | {"vehicle": name, "fault_thruster": count - 1})
        for name, count in COUNTS.items()
    },
    "ahead": ("currents-v1", "ahead", STILL),
}


def vehicle(name: str, count: int) -> str:
    """Return the file of a vehicle with so many thrusters."""
    further = {f"further {number}": FIVE["sway"] for number in range(count - 5)}
    thrusters = [
        THRUSTER.format(name=name, y=y, direction=direction)
        for name, (y, direction) in {**FIVE, **further}.items()
    ]
    return VEHICLE.format(name=name, count=count) + "".join(thrusters)


@pytest.fixture(scope="module")
def added(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """What forms, documentation and a trial with each of the added things give."""
    folder = tmp_path_factory.mktemp("added")
    files = {**HARBOUR, **DRIFTER, "ahead.py": AHEAD}
    files |= {f"{name}.toml": vehicle(name, count) for name, count in COUNTS.items()}
    for file, text in files.items():
        (folder / file).parent.mkdir(exist_ok=True)
        (folder / file).write_text(text, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-c", START, str(folder), json.dumps(TRIALS)],
        env={**os.environ, "PYTHONPATH": str(folder)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    result: dict[str, Any] = json.loads(done.stdout)
    return result


def test_a_form_and_the_documentation_load_nothing_heavy_of_what_is_added(
    added: dict[str, Any],
) -> None:
    assert added["light"]


def test_a_second_station_keeping_benchmark_with_a_metric_is_one_folder(
    added: dict[str, Any],
) -> None:
    summary, form = added["trials"]["harbour"]["summary"], added["properties"]["harbour-v1"]

    first, second = summary["levels"]
    assert form["levels"]["default"] == [0.05, 0.15]
    assert form["levels"]["title"] == added["properties"]["currents-v1"]["levels"]["title"]
    assert (first["speed"], second["speed"]) == (0.05, 0.15)
    assert 0 < first["whole_outside_s"] <= 2.0
    total = first["whole_outside_s"] + second["whole_outside_s"]
    assert summary["overall"]["whole_outside_s"] == pytest.approx(total)
    assert summary["own_score"]["value"] == pytest.approx(2 * total)
    assert "| `outside_s` | Time outside 1 mm | s | control steps with d > 1 mm" in added["page"]


def test_a_tracker_with_an_option_is_one_folder(added: dict[str, Any]) -> None:
    with_tracker = [form for form in added["properties"].values() if "tracker" in form]

    assert len(with_tracker) > 1
    for form in with_tracker:
        assert form["drift_px"]["x-applies"] == {"tracker": ["drifter"]}
        assert (form["drift_px"]["maximum"], form["drift_px"]["x-unit"]) == (3, "px")
        assert "drifter" in form["warp"]["x-applies"]["tracker"]
        label = form["tracker"]["x-labels"]["drifter"]
        assert label == "First corners, moved a little; not bit-identical on all processors"
    assert added["trials"]["drifter"]["summary"]["levels"][0]["p5_percent"] < 10.0


@pytest.mark.parametrize("name", COUNTS)
def test_a_vehicle_with_any_number_of_thrusters_is_one_file(
    added: dict[str, Any], name: str
) -> None:
    count, trial = COUNTS[name], added["trials"][name]

    thrusts = [column for chart in trial["charts"] for column in chart if "thrust" in column]
    form = added["properties"]["currents-v1"]
    assert form["vehicle"]["x-labels"][name] == f"Girona with {count} thrusters"
    assert form["fault_thruster"]["maximum"] == max(*COUNTS.values(), most_thrusters()) - 1
    assert thrusts == [f"thrust_{i}" for i in range(count)]
    assert trial["width"] == WIDTH + max(count - COMMON_THRUSTERS, 0)
    assert trial["summary"]["levels"][0]["whole_max_m"] < 1.0


def test_a_controller_is_one_file(added: dict[str, Any]) -> None:
    trial = added["trials"]["ahead"]

    assert trial["built_in"]["ahead"] == "Full ahead"
    assert trial["summary"]["levels"][0]["whole_max_m"] > 0.3
