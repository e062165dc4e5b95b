"""Trackers: they find the target in the camera's pictures, from one to the next.

Importing this package loads neither Numba nor OpenCV; `make` loads what the chosen tracker needs.
"""

from collections.abc import Callable
from importlib import import_module

from seamark.sim.registry import TRACKERS, TRUTH
from seamark.sim.trackers.choices import options_of, refusals
from seamark.sim.trackers.interface import Corners, Track, Tracker, Window

__all__ = ["Corners", "Track", "Tracker", "Window", "make", "warm_up"]


def make(name: str, *, truth: Callable[[], Corners] | None = None, **options: object) -> Tracker:
    """Return a new tracker.

    Parameters
    ----------
    name : str
        One of the registry's TRACKERS, or TRUTH.
    truth : callable
        Gives the true corners (4, 2) [px] of the picture at hand; TRUTH alone asks it.
    options
        Those in the entry's `options`; others are refused, so that no choice is silently ignored.

    Raises
    ------
    ValueError
        The name, an option or their combination is not offered; the text says why.
    """
    if name != TRUTH and name not in TRACKERS:
        raise ValueError(f"tracker {name!r} is none of {', '.join([*TRACKERS, TRUTH])}")
    unknown = sorted(set(options) - set(options_of(name)))
    if unknown:
        raise ValueError(f"tracker {name!r} has no option {', '.join(unknown)}")
    errors = refusals(name, options)
    if errors:
        raise ValueError(" ".join(errors.values()))
    if name == TRUTH:
        return _truth(truth)
    tracker: Tracker = TRACKERS[name].load()(**options)
    return tracker


def _truth(truth: Callable[[], Corners] | None) -> Tracker:
    if truth is None:
        raise ValueError("tracker 'truth' needs a source of the true corners")
    from seamark.sim.trackers.truth import TruthTracker  # noqa: PLC0415  # light, but not for every form

    return TruthTracker(truth=truth)


def warm_up() -> None:
    """Load all compiled code, so that forked simulators start at once."""
    import_module("seamark.sim.trackers.template.warm_up").run()
