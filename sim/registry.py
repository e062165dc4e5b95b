"""Names of everything a form offers, with labels and where the code lives.

Light on purpose: importing it loads neither Numba nor OpenCV. Adding a thing is one file and one
line here; an entry that does not load stops the start (`load_all`), it does not warn.
"""

from typing import TYPE_CHECKING

from sim.entry import Entry

if TYPE_CHECKING:
    from sim.benchmarks import Benchmark

BENCHMARKS = {
    "currents-v1": Entry(
        "Position controllers in changing currents", "sim.benchmarks.currents_v1:BENCHMARK"
    ),
}
VEHICLES = {
    "girona500": Entry("Girona 500", "sim.vehicles.girona500:VEHICLE"),
    "girona500-uwsim": Entry(
        "Girona 500 as in UWSim (the paper's plant)", "sim.vehicles.girona500_uwsim:VEHICLE"
    ),
    "bluerov2-heavy": Entry("BlueROV2 Heavy", "sim.vehicles.bluerov2_heavy:VEHICLE"),
}
CONTROLLERS = {
    "pi": Entry("PI", "sim.controllers.pi:Controller"),
    "p": Entry("P", "sim.controllers.p:Controller"),
}
TRACKERS = {
    "esm": Entry("Template tracker (ESM family)", "sim.trackers.template:TemplateTracker"),
}
TRUTH = "truth"  # not a tracker: the true corners, to look at a controller alone; never ranks

WARPS = {
    "translation": "Translation",
    "rt": "Rotation + translation",
    "srt": "Scale + rotation + translation",
    "affine": "Affine",
    "homography": "Homography",
}
CRITERIA = {
    "zncc": "Zero-mean normalised cross-correlation",
    "ssd": "Sum of squared differences",
}
METHODS = {
    "esm": "Efficient second-order minimisation",
    "inverse_compositional": "Inverse compositional",
    "forward_compositional": "Forward compositional",
}


def labels(entries: dict[str, Entry]) -> dict[str, str]:
    """Return name -> label, as the form shows them."""
    return {name: entry.label for name, entry in entries.items()}


def benchmark(name: str) -> "Benchmark":
    """Return a benchmark by its name.

    Raises
    ------
    KeyError
        If there is none of that name.
    """
    loaded: Benchmark = BENCHMARKS[name].load()
    return loaded


def load_all() -> None:
    """Load every entry, so that a broken one stops the start and not somebody's run."""
    for entries in (BENCHMARKS, VEHICLES, CONTROLLERS, TRACKERS):
        for entry in entries.values():
            entry.load()
    for name in BENCHMARKS:
        benchmark(name).load()
