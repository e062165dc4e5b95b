"""Trackers: they find the target in the camera's images, from one to the next.

Each is declared in the module that the registry names. Importing this package or a declaration
loads neither Numba nor OpenCV; `make` loads what the chosen tracker needs.
"""

from collections.abc import Callable
from importlib import import_module
from pkgutil import resolve_name

from seamark.sim.registry import TRACKERS, TRUTH
from seamark.sim.trackers.declaration import Errors, OptionValues, TrackerDeclaration
from seamark.sim.trackers.interface import Corners, Track, Tracker, Window

__all__ = [
    "Corners",
    "Track",
    "Tracker",
    "TrackerDeclaration",
    "Window",
    "declaration",
    "make",
    "option_errors",
    "option_names",
    "warm_up",
]


def declaration(name: str) -> TrackerDeclaration:
    """Return the declaration of a tracker.

    Raises
    ------
    KeyError
        If there is none of that name; the ground truth is not a tracker.
    """
    declared: TrackerDeclaration = resolve_name(TRACKERS[name])
    return declared


def option_names(name: str) -> tuple[str, ...]:
    """Return the names of a tracker's options; ground truth and unknown trackers have none."""
    return declaration(name).option_names if name in TRACKERS else ()


def option_errors(name: str, values: OptionValues) -> Errors:
    """Return option -> why the tracker does not accept it; empty if all is well.

    A tracker that this machine cannot run is an error of the option `tracker`.
    """
    if name == TRUTH:
        return {}
    declared = declaration(name)
    if reason := declared.unavailable():
        return {"tracker": f"tracker {name} is not available: {reason}."}
    return declared.errors(values)


def make(name: str, *, truth: Callable[[], Corners] | None = None, **options: object) -> Tracker:
    """Return a new tracker.

    Parameters
    ----------
    name : str
        One of the registry's TRACKERS, or TRUTH.
    truth : callable
        Returns the true corners (4, 2) [px] of the current image; only TRUTH uses it.
    options
        Those that the tracker declares; others are errors, so that none is silently ignored.

    Raises
    ------
    ValueError
        If the name, an option or their combination is not supported; the text says why.
    """
    if name != TRUTH and name not in TRACKERS:
        raise ValueError(f"tracker {name!r} must be one of {', '.join([*TRACKERS, TRUTH])}")
    unknown = sorted(set(options) - set(option_names(name)))
    if unknown:
        raise ValueError(f"tracker {name!r} has no option {', '.join(unknown)}")
    if errors := option_errors(name, options):
        raise ValueError(" ".join(errors.values()))
    if name == TRUTH:
        return _truth(truth)
    return declaration(name).load()(**options)


def _truth(truth: Callable[[], Corners] | None) -> Tracker:
    if truth is None:
        raise ValueError("tracker 'truth' needs a source of the true corners")
    from seamark.sim.trackers.truth import TruthTracker  # noqa: PLC0415  # not for every form

    return TruthTracker(truth=truth)


def warm_up() -> None:
    """Load all compiled code, so that forked simulators start at once."""
    import_module("seamark.sim.trackers.warm_up").run()
