"""Names of everything a form offers, with labels and where the code lives.

Light on purpose: importing it loads neither Numba nor OpenCV. Adding a thing is one file and one
line here; an entry that does not load stops the start (`load_all`), it does not warn.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from sim.entry import Entry, TrackerEntry

if TYPE_CHECKING:
    from sim.benchmarks import Benchmark

BENCHMARKS = {
    "currents-v1": Entry(
        "Position controllers in changing currents", "sim.benchmarks.currents_v1:BENCHMARK"
    ),
    "visibility-v1": Entry(
        "Trackers in water that gets worse", "sim.benchmarks.visibility_v1:BENCHMARK"
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
        "Template tracker (ESM family)", "sim.trackers.template:TemplateTracker", _TEMPLATE
    ),
    "klt": TrackerEntry(
        "Corners and optical flow (KLT + RANSAC, OpenCV)",
        "sim.trackers.klt:KltTracker",
        ("warp", "klt_points", "klt_from"),
        exact=False,
    ),
    "ecc": TrackerEntry(
        "Enhanced correlation coefficient (ECC, OpenCV)",
        "sim.trackers.ecc:EccTracker",
        ("warp", "ecc_iterations", "predict_motion"),
        exact=False,
    ),
    "kcf": TrackerEntry(
        "Kernelised correlation filter (KCF, OpenCV; an upright box)",
        "sim.trackers.filters:KcfTracker",
        exact=False,
    ),
    "csrt": TrackerEntry(
        "Filter with channel and spatial reliability (CSRT, OpenCV; an upright box)",
        "sim.trackers.filters:CsrtTracker",
        exact=False,
    ),
    "visp": TrackerEntry(
        "ViSP's template trackers",
        "sim.trackers.visp.tracker:VispTracker",
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
        "sim.trackers.box:BoxTracker",
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
