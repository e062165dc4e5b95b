"""Trackers: they find the target in the camera's pictures, from one to the next.

Importing this package loads neither Numba nor OpenCV; `make` loads what the chosen tracker needs.
"""

from collections.abc import Callable
from importlib import import_module
from typing import NamedTuple

from sim.trackers.choices import RANGES
from sim.trackers.interface import Corners, Track, Tracker, Window

__all__ = ["TRACKERS", "Corners", "Entry", "Track", "Tracker", "Window", "make", "warm_up"]


class Entry(NamedTuple):
    """A tracker people can choose."""

    label: str
    path: str  # module:class
    options: tuple[str, ...]  # which of make()'s options mean something to it


_TEMPLATE = ("warp", "criterion", "method", *RANGES, "predict_motion")
TRACKERS = {
    "esm": Entry(
        "Template alignment (ESM)",
        "sim.trackers.template:TemplateTracker",
        _TEMPLATE,
    ),
    "truth": Entry("Ground truth (perfect tracker)", "sim.trackers.truth:TruthTracker", ()),
}


def make(
    name: str, *, truth: Callable[[], Corners] | None = None, **options: str | float | bool
) -> Tracker:
    """Return a new tracker.

    Parameters
    ----------
    name : str
        One of TRACKERS.
    truth : callable
        Gives the true corners (4, 2) [px] of the picture at hand; `truth` alone asks it.
    options
        Those in the entry's `options`; others are refused, so that no choice is silently ignored.

    Raises
    ------
    ValueError
        The name, an option or their combination is not offered; the text says why.
    """
    entry = TRACKERS.get(name)
    if entry is None:
        raise ValueError(f"tracker {name!r} is none of {', '.join(TRACKERS)}")
    unknown = sorted(set(options) - set(entry.options))
    if unknown:
        raise ValueError(f"tracker {name!r} has no option {', '.join(unknown)}")
    if name == "truth":
        if truth is None:
            raise ValueError("tracker 'truth' needs a source of the true corners")
        options = {**options, "truth": truth}  # type: ignore[dict-item]
    module, _, attribute = entry.path.partition(":")
    tracker: Tracker = getattr(import_module(module), attribute)(**options)
    return tracker


def warm_up() -> None:
    """Load all compiled code, so that forked simulators start at once."""
    import_module("sim.trackers.warm").run()
