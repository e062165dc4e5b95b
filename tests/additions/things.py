"""One more of each thing, as files that a checkout would have: name -> text."""

BENCHMARK = {
    "harbour_v1/__init__.py": "",
    "harbour_v1/definition.py": """
from dataclasses import replace

from seamark.sim.benchmarks.benchmark import Baseline
from seamark.sim.benchmarks.station_keeping.definition import station_keeping_benchmark
from seamark.sim.settings.setting import override
from seamark.sim.settings.station_keeping import StationKeepingSettings

INHERITED = StationKeepingSettings.model_fields


class HarbourSettings(StationKeepingSettings):
    levels: tuple[float, ...] = override(INHERITED["levels"], (0.05, 0.15))


BENCHMARK = replace(
    station_keeping_benchmark(
        name="harbour-v1",
        title="Station keeping in a harbour",
        summary="Keep station in a weak tide.",
        configuration=HarbourSettings,
        baselines={"p": Baseline("P", "p")},
        quick_settings={"level_duration_s": 2.0, "settle_s": 1.0},
    ),
    question="Which position controller keeps station in a harbour?",
)
""",
}
VEHICLE = {
    "dory.toml": """
format = 1
name = "dory"
title = "Dory with oars"
summary = "A small boat below the water."
extends = "bluerov2-heavy"

[drawing]
solids = [
  { shape = "capsule", size = [0.5, 0.2, 0.2], centre = [0, 0, 0], colour = "#e9f0f2" },
]
""",
}
TRACKER = {
    "drifter/__init__.py": """
from seamark.sim.trackers.declaration import TrackerDeclaration

TRACKER = TrackerDeclaration(
    label="Drifting corners", path="drifter.tracker:Drifter", options=(), exact=True
)
""",
    "drifter/tracker.py": """
class Drifter:
    pass
""",
}
CONTROLLER = {
    "ahead.py": """
class Controller:
    label = "Full ahead"
""",
}
LANGUAGE = {
    "formulas/__init__.py": """
from dataclasses import replace
from pathlib import Path

from seamark.sandbox.languages.language import CONTROLLER, Declarations
from seamark.sandbox.languages.python import PYTHON
from seamark.sandbox.languages.sample import sample

STARTER = sample(Path(__file__).with_name("controller.formulas"))
FORMULAS = replace(
    PYTHON,
    name="formulas",
    label="Formulas (one for each axis)",
    suffixes=(".formulas",),
    self_test=STARTER,
    starters=(STARTER,),
    conformance=(STARTER,),
    archive_mains=(),
    roles=(CONTROLLER,),
    syntax="text",
    declarations=Declarations.COMMENTS,
    states_encoding=False,
    in_the_box="Nothing but `min` and `max`.",
)
""",
    "formulas/controller.formulas": "# @parameter gain 0.5\ngain * error_x\n",
}
ADMIN_PAGE = {
    "weather.py": """
from seamark.server.pages.administration.admin_page import admin_page

WEATHER = admin_page("weather", __name__, label="Weather at sea", path="/weather")


@WEATHER.blueprint.get("")
def show() -> str:
    return "Fog"
""",
}
FILES = BENCHMARK | VEHICLE | TRACKER | CONTROLLER | LANGUAGE | ADMIN_PAGE
