"""Names of everything that can be chosen, and where each is declared.

Adding a thing is one file or folder and one line here: its name and the path of its declaration as
`pkgutil.resolve_name` reads it, module:attribute. The declaration has the label and the settings.
It is light: it loads neither Numba nor OpenCV until a run needs its code. A vehicle is a file of
data alone, which is found. An entry that does not load stops the start (`load_all`).
"""

from pathlib import Path
from pkgutil import resolve_name
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from seamark.sim.benchmarks.benchmark import Benchmark

BENCHMARKS = {  # the current ones first
    "currents-v3": "seamark.sim.benchmarks.currents_v3.definition:BENCHMARK",
    "visibility-v3": "seamark.sim.benchmarks.visibility_v3.definition:BENCHMARK",
    "track-v1": "seamark.sim.benchmarks.track_v1.definition:BENCHMARK",
    "dock-v1": "seamark.sim.benchmarks.dock_v1.definition:BENCHMARK",
    "patterns-v1": "seamark.sim.benchmarks.patterns_v1.definition:BENCHMARK",
    "mission-v1": "seamark.sim.benchmarks.mission_v1.definition:BENCHMARK",
    "recover-v1": "seamark.sim.benchmarks.recover_v1.definition:BENCHMARK",
    "valve-v1": "seamark.sim.benchmarks.valve_v1.definition:BENCHMARK",
    "connect-v1": "seamark.sim.benchmarks.connect_v1.definition:BENCHMARK",
    "currents-v2": "seamark.sim.benchmarks.currents_v2.definition:BENCHMARK",
    "currents-v1": "seamark.sim.benchmarks.currents_v1.definition:BENCHMARK",
    "visibility-v2": "seamark.sim.benchmarks.visibility_v2.definition:BENCHMARK",
    "visibility-v1": "seamark.sim.benchmarks.visibility_v1.definition:BENCHMARK",
}
DEFAULT_BENCHMARK = next(iter(BENCHMARKS))  # of the site, commands and logs, where none is named


def newest_version(name: str) -> str:
    """Return the name of a benchmark's newest version, such as currents-v3 for currents-v1."""
    family = name.rpartition("-v")[0]
    versions = [one for one in BENCHMARKS if one.rpartition("-v")[0] == family]
    return max(versions, key=lambda one: int(one.rpartition("-v")[2]))


_FIRST_VEHICLES = ("girona500", "girona500-uwsim", "bluerov2-heavy")  # others follow by name


def _vehicles() -> dict[str, Path]:
    """Return name -> file of the vehicles, in the order of forms."""
    files = {path.stem: path for path in sorted(Path(__file__).parent.glob("vehicles/*.toml"))}
    return {name: files[name] for name in _FIRST_VEHICLES} | files


def _files(folder: str) -> dict[str, Path]:
    """Return name -> file of what a folder of `vehicles` has."""
    files = sorted((Path(__file__).parent / "vehicles" / folder).glob("*.toml"))
    return {path.stem: path for path in files}


VEHICLES = _vehicles()
ARMS, THINGS = _files("arms"), _files("things")
TOOL = "tool"  # the task of a tool before a target, for all that keep station and some more
CONTROLLERS = {
    "pi": "seamark.sim.control.position.pi:Controller",
    "p": "seamark.sim.control.position.p:Controller",
    "pid": "seamark.sim.control.position.pid:Controller",
    "pi-ff": "seamark.sim.control.position.pi_ff:Controller",
    "smc": "seamark.sim.control.position.smc:Controller",
    "lqr": "seamark.sim.control.position.lqr:Controller",
    "mpc": "seamark.sim.control.position.mpc:Controller",
    "l1": "seamark.sim.control.position.l1:Controller",
}
# Marks on the leaderboard, from the bottom to what thrust alone allows. Nobody can submit them.
REFERENCE_CONTROLLERS = {
    "nothing": "seamark.sim.control.position.nothing:Controller",
    "blind": "seamark.sim.control.position.blind:Controller",
    "pixels": "seamark.sim.control.position.pixels.controller:Controller",
    "oracle": "seamark.sim.control.position.oracle:Controller",
}
# For other tasks, most of them with an arm; marks on the leaderboards last.
TASK_CONTROLLERS = {
    TOOL: {"into-current": "seamark.sim.control.position.into_current:Controller"},
    "track": {
        "ilos": "seamark.sim.control.track.guidance:IntegralLineOfSight",
        "los": "seamark.sim.control.track.guidance:LineOfSight",
        "mpc": "seamark.sim.control.track.mpc:RouteMpc",
        "into-flow": "seamark.sim.control.track.guidance:IntoFlow",
        "l1": "seamark.sim.control.track.l1:AdaptiveLineOfSight",
        "pi": "seamark.sim.control.position.pi:Controller",
        "p": "seamark.sim.control.position.p:Controller",
    },
    "dock": {
        "staged": "seamark.sim.control.dock.entries:Staged",
        "straight": "seamark.sim.control.dock.entries:Straight",
        "acoustic": "seamark.sim.control.dock.entries:Acoustic",
    },
    "mission": {
        "chain": "seamark.sim.control.manipulation.mission:Chain",
    },
    "recover": {
        "resolved-rate": "seamark.sim.control.manipulation.recover:ResolvedRate",
        "scripted": "seamark.sim.control.manipulation.recover:Scripted",
    },
    "valve": {
        "resolved-rate": "seamark.sim.control.manipulation.valve:ResolvedRate",
        "scripted": "seamark.sim.control.manipulation.valve:Scripted",
    },
    "connect": {
        "resolved-rate": "seamark.sim.control.manipulation.connector:ResolvedRate",
        "scripted": "seamark.sim.control.manipulation.connector:Scripted",
    },
}
REFERENCE_TASK_CONTROLLERS = {
    TOOL: {},
    "track": {
        "nothing": "seamark.sim.control.position.nothing:Controller",
        "blind": "seamark.sim.control.track.guidance:Blind",
        "oracle": "seamark.sim.control.track.oracle:Oracle",
    },
    "dock": {
        "nothing": "seamark.sim.control.position.nothing:Controller",
        "blind": "seamark.sim.control.dock.entries:Blind",
        "oracle": "seamark.sim.control.dock.oracle:Oracle",
    },
    "mission": {
        "nothing": "seamark.sim.control.position.nothing:Controller",
        "lawnmower": "seamark.sim.control.manipulation.mission:Lawnmower",
        "oracle": "seamark.sim.control.manipulation.oracle:MissionOracle",
    },
    "recover": {
        "nothing": "seamark.sim.control.position.nothing:Controller",
        "blind": "seamark.sim.control.manipulation.recover:Blind",
        "imitation": "seamark.sim.control.manipulation.imitation.controller:Imitation",
        "oracle": "seamark.sim.control.manipulation.oracle:RecoverOracle",
    },
    "valve": {
        "nothing": "seamark.sim.control.position.nothing:Controller",
        "blind": "seamark.sim.control.manipulation.valve:Blind",
        "oracle": "seamark.sim.control.manipulation.oracle:ValveOracle",
    },
    "connect": {
        "nothing": "seamark.sim.control.position.nothing:Controller",
        "blind": "seamark.sim.control.manipulation.connector:Blind",
        "oracle": "seamark.sim.control.manipulation.connector_oracle:ConnectorOracle",
    },
}
TRACKERS = {
    "esm": "seamark.sim.trackers.template:TRACKER",
    "klt": "seamark.sim.trackers.klt:TRACKER",
    "ecc": "seamark.sim.trackers.ecc:TRACKER",
    "kcf": "seamark.sim.trackers.correlation_filters:KCF",
    "csrt": "seamark.sim.trackers.correlation_filters:CSRT",
    "mosse": "seamark.sim.trackers.mosse:TRACKER",
    "median-flow": "seamark.sim.trackers.median_flow:TRACKER",
    "visp": "seamark.sim.trackers.visp:TRACKER",
    "box": "seamark.sim.trackers.box:TRACKER",
}
TRUTH = "truth"  # not a tracker: the true corners, to test a controller alone; never ranks

DETECTORS = {
    "template": "seamark.sim.detectors.template:DETECTOR",
    "markers": "seamark.sim.detectors.markers:DETECTOR",
    "orb": "seamark.sim.detectors.orb:DETECTOR",
}
# Marks on the leaderboard: the first two do not look at the image. Nobody can submit them.
REFERENCE_DETECTORS = {
    "nothing": "seamark.sim.detectors.references:NOTHING",
    "random": "seamark.sim.detectors.references:RANDOM",
    "network": "seamark.sim.detectors.network:NETWORK",
}
# They find lettered boxes in the grey image of a vehicle that searches for one.
BOX_DETECTORS = {
    "face": "seamark.sim.detectors.faces:FACE",
    "outline": "seamark.sim.detectors.faces:OUTLINE",
}


def benchmark(name: str) -> "Benchmark":
    """Return a benchmark by its name.

    Raises
    ------
    KeyError
        If there is none of that name.
    """
    loaded: Benchmark = resolve_name(BENCHMARKS[name])
    return loaded


def controllers(task: str) -> dict[str, str]:
    """Return name -> path of what users can choose for a task; "": to keep station."""
    return _of_task(task, CONTROLLERS, TASK_CONTROLLERS)


def reference_controllers(task: str) -> dict[str, str]:
    """Return name -> path of what only marks on a leaderboard use, some of which see the truth."""
    return _of_task(task, REFERENCE_CONTROLLERS, REFERENCE_TASK_CONTROLLERS)


def _of_task(
    task: str, stations: dict[str, str], others: dict[str, dict[str, str]]
) -> dict[str, str]:
    own = others[task] if task else {}
    return stations | own if task in ("", TOOL) else own


def controller_path(name: str, task: str = "") -> str:
    """Return the path of a controller; KeyError if there is none of that name for the task."""
    return (controllers(task) | reference_controllers(task))[name]


def load_all() -> None:
    """Load every entry and its code, so that a broken one stops the start and not a user's run."""
    for name in VEHICLES:
        resolve_name("seamark.sim.vehicles:load")(name)
    for task in ("", *TASK_CONTROLLERS):
        for path in (*controllers(task).values(), *reference_controllers(task).values()):
            resolve_name(path)
    for entries in (BENCHMARKS, TRACKERS, DETECTORS, REFERENCE_DETECTORS, BOX_DETECTORS):
        for path in entries.values():
            resolve_name(path).load()
