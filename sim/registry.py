"""Names of everything that can be chosen, and where each is declared.

Adding a thing is one file or folder and one line here: name -> "module:attribute". Each declares
its own label and settings. Light: a declaration loads neither Numba nor OpenCV until a run needs
its code. An entry that does not load stops the start (`load_all`); it does not warn.
"""

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from seamark.sim.benchmarks.benchmark import Benchmark

BENCHMARKS = {
    "currents-v1": "seamark.sim.benchmarks.currents_v1.definition:BENCHMARK",
    "visibility-v1": "seamark.sim.benchmarks.visibility_v1.definition:BENCHMARK",
}
VEHICLES = {
    "girona500": "seamark.sim.vehicles.girona500:VEHICLE",
    "girona500-uwsim": "seamark.sim.vehicles.girona500_uwsim:VEHICLE",
    "bluerov2-heavy": "seamark.sim.vehicles.bluerov2_heavy:VEHICLE",
}
CONTROLLERS = {
    "pi": "seamark.sim.control.position.pi:Controller",
    "p": "seamark.sim.control.position.p:Controller",
}
TRACKERS = {
    "esm": "seamark.sim.trackers.template:TRACKER",
    "klt": "seamark.sim.trackers.klt:TRACKER",
    "ecc": "seamark.sim.trackers.ecc:TRACKER",
    "kcf": "seamark.sim.trackers.correlation_filters:KCF",
    "csrt": "seamark.sim.trackers.correlation_filters:CSRT",
    "visp": "seamark.sim.trackers.visp:TRACKER",
    "box": "seamark.sim.trackers.box:TRACKER",
}
TRUTH = "truth"  # not a tracker: the true corners, to test a controller alone; never ranks


def load(path: str) -> Any:  # a class, a function or a data object
    """Return what a path, module:attribute, names.

    Raises
    ------
    ImportError, AttributeError
        If the path names nothing: the registry is wrong.
    """
    module, _, attribute = path.partition(":")
    return getattr(importlib.import_module(module), attribute)


def benchmark(name: str) -> "Benchmark":
    """Return a benchmark by its name.

    Raises
    ------
    KeyError
        If there is none of that name.
    """
    loaded: Benchmark = load(BENCHMARKS[name])
    return loaded


def load_all() -> None:
    """Load every entry and its code, so that a broken one stops the start and not a user's run."""
    for path in (*VEHICLES.values(), *CONTROLLERS.values()):
        load(path)
    for path in (*BENCHMARKS.values(), *TRACKERS.values()):
        load(path).load()
