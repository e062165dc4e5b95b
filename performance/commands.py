"""Every command of `./run performance`, by the subject that it measures."""

import ast
import importlib
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

from performance.tables import text

QUICK = ("full_run", "physics", "camera", "exchange")
ALL = "all"
# Name -> module. A table has `rows()`, or `table()` if it has columns of its own. It prints and
# changes nothing.
TABLES = {
    "full_run": "simulator.full_run",
    "physics": "simulator.physics",
    "multibody": "simulator.multibody",
    "gym": "simulator.gym",
    "vision": "simulator.vision",
    "start": "simulator.start",
    "currents": "simulator.currents",
    "growth": "simulator.growth",
    "scaling": "simulator.scaling",
    "static_limits": "simulator.static_limits",
    "exchange": "sandbox.exchange",
    "neighbours": "sandbox.neighbours",
    "leaks": "sandbox.leaks",
    "camera": "perception.camera",
    "sonar": "perception.sonar",
    "training_images": "perception.training_images",
    "box_detectors": "perception.box_detectors",
    "trackers": "perception.trackers.page",
    "leaderboard": "service.database.leaderboard",
    "many_runs": "service.database.many_runs",
    "start_latency": "service.queue.start_latency",
    "fake_runs": "service.queue.fake_runs",
    "claims": "service.queue.claims",
    "load_model": "service.queue.load_model",
    "streams": "service.web.streams",
    "live_lag": "service.web.live_lag",
    "player": "service.web.player",
    "downloads": "service.web.downloads",
    "upgrade_flood": "service.web.upgrade_flood",
    "strangers_bytes": "service.web.strangers_bytes",
}
ADJUSTABLE = frozenset({"trackers", "leaderboard", "many_runs", "fake_runs", "claims"})
# Name -> module with `main(arguments)`, as adjustable tables have it too. It writes files or takes
# long, and is not part of `all`.
OTHERS = {
    "validation": "simulator.validation.page",
    "vehicle_versions": "simulator.validation.versions",
    "entry_order": "simulator.validation.entries",
    "floating_arm": "simulator.validation.floating_arm.records",
    "paper_figures": "simulator.validation.experiment",
    "visibility": "perception.visibility.measurement",
    "headroom": "statistics.headroom.currents",
    "intervention_headroom": "statistics.headroom.interventions",
    "patterns_headroom": "statistics.headroom.patterns",
    "dock_headroom": "statistics.headroom.docks",
    "route_headroom": "statistics.headroom.routes",
    "visibility_headroom": "statistics.headroom.visibility",
    "adversaries": "statistics.adversaries",
    "population": "statistics.population",
    "coverage": "statistics.coverage",
    "finals": "statistics.finals",
    "identification_coverage": "statistics.identification.coverage",
    "selection": "statistics.selection",
    "reference_results": "statistics.reference_results",
    "fake_machines": "service.queue.fake_machines",
    "competition_rush": "service.web.competition_rush",
    "slow_start": "service.web.slow_start",
    "generated_client": "interoperability.generated_client",
    "bridges": "interoperability.bridges",
    "foxglove": "interoperability.foxglove",
    "benchmark_pictures": "figures.benchmark_pictures",
    "camera_figures": "figures.camera",
    "tracker_figures": "figures.trackers",
    "training_figure": "figures.training",
    "seconds_to_score": "figures.seconds_to_score",
    "tutorial_figure": "figures.tutorial",
    "compared_figures": "figures.compared",
    "player_figures": "figures.player",
    "demo_recording": "figures.demo_recording",
    "screenshots": "figures.screenshots",
    "synthetic_current": "figures.synthetic_current",
    "turbulence": "figures.turbulence",
    "sonar_figure": "figures.sonar",
}
MODULES = {name: f"performance.{module}" for name, module in (TABLES | OTHERS).items()}


def run(name: str, arguments: Sequence[str]) -> int:
    """Print a table, or run a command; return the exit code."""
    module = importlib.import_module(MODULES[name])
    if name in OTHERS or arguments:
        code: int = module.main(arguments)
        return code
    own = getattr(module, "table", None)
    print(f"\n{name}\n{own() if own else text(module.rows())}", flush=True)
    return 0


def takes_arguments(name: str) -> bool:
    """Return whether words after a name are for the command."""
    return name in OTHERS or name in ADJUSTABLE


def described() -> str:
    """Return a line for each command: its name and the first line of its module."""
    lines = ["Tables:", *map(_line, TABLES), "", "Others:", *map(_line, OTHERS)]
    return "\n".join(lines)


def _line(name: str) -> str:
    spec = find_spec(MODULES[name])  # not imported: MuJoCo and Chromium may be missing
    source = Path(spec.origin).read_text("utf-8") if spec and spec.origin else ""
    summary = (ast.get_docstring(ast.parse(source)) or "").partition("\n")[0]
    return f"  {name:20} {summary}"
