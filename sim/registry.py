"""Names of everything a form offers, with labels and where the code lives.

Light on purpose: importing it loads neither Numba nor OpenCV. Adding a thing is one file and one
line here; an entry that does not load stops the start (`load_all`), it does not warn.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from seamark.sim.entry import Entry, TrackerEntry

if TYPE_CHECKING:
    from seamark.sim.benchmarks.benchmark import Benchmark

BENCHMARKS = {
    "currents-v1": Entry(
        "Position controllers in changing currents",
        "seamark.sim.benchmarks.currents_v1.definition:BENCHMARK",
    ),
    "visibility-v1": Entry(
        "Trackers in water that gets worse",
        "seamark.sim.benchmarks.visibility_v1.definition:BENCHMARK",
    ),
}
VEHICLES = {
    "girona500": Entry("Girona 500", "seamark.sim.vehicles.girona500:VEHICLE"),
    "girona500-uwsim": Entry(
        "Girona 500 as in UWSim (the paper's plant)", "seamark.sim.vehicles.girona500_uwsim:VEHICLE"
    ),
    "bluerov2-heavy": Entry("BlueROV2 Heavy", "seamark.sim.vehicles.bluerov2_heavy:VEHICLE"),
}
CONTROLLERS = {
    "pi": Entry("PI", "seamark.sim.control.position.pi:Controller"),
    "p": Entry("P", "seamark.sim.control.position.p:Controller"),
}
TRUTH = "truth"  # not a tracker: the true corners, to look at a controller alone; never ranks
_TEMPLATE = (
    "warp",
    "criterion",
    "method",
    "pyramid_levels",
    "coarse_iterations",
    "fine_iterations",
    "stop_px",
    "sampling_px",
    "template_margin_px",
    "predict_motion",
    "search_px",
    "reacquire_px",
)
TRACKERS = {
    "esm": TrackerEntry(
        "Template tracker (ESM family)",
        "seamark.sim.trackers.template.tracker:TemplateTracker",
        _TEMPLATE,
    ),
    "klt": TrackerEntry(
        "Corners and optical flow (KLT + RANSAC, OpenCV)",
        "seamark.sim.trackers.klt:KltTracker",
        ("warp", "klt_points", "klt_from"),
        exact=False,
    ),
    "ecc": TrackerEntry(
        "Enhanced correlation coefficient (ECC, OpenCV)",
        "seamark.sim.trackers.ecc:EccTracker",
        ("warp", "ecc_iterations", "predict_motion"),
        exact=False,
    ),
    "kcf": TrackerEntry(
        "Kernelised correlation filter (KCF, OpenCV; an upright box)",
        "seamark.sim.trackers.correlation_filters:KcfTracker",
        exact=False,
    ),
    "csrt": TrackerEntry(
        "Filter with channel and spatial reliability (CSRT, OpenCV; an upright box)",
        "seamark.sim.trackers.correlation_filters:CsrtTracker",
        exact=False,
    ),
    "visp": TrackerEntry(
        "ViSP's template trackers",
        "seamark.sim.trackers.visp.tracker:VispTracker",
        (
            "warp",
            "criterion",
            "method",
            "pyramid_levels",
            "sampling_px",
            "template_margin_px",
            "visp_iterations",
            "visp_sl3",
        ),
        exact=False,
    ),
    "box": TrackerEntry(
        "Upright box by correlation (OpenCV; a baseline)",
        "seamark.sim.trackers.box:BoxTracker",
        ("search_px",),
        exact=False,
    ),
}


def labels(entries: Mapping[str, Entry]) -> dict[str, str]:
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
