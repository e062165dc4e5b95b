"""Detectors: they find what lies on the bottom in single images, and say what it is.

Each is declared in the module that the registry names. Importing this package or a declaration
loads neither Numba nor OpenCV; `make` loads what the chosen detector needs.
"""

from importlib import import_module
from pkgutil import resolve_name

from seamark.sim.detectors.declaration import DetectorDeclaration
from seamark.sim.detectors.interface import MOST, Corners, Detection, Detector, Image
from seamark.sim.registry import BOX_DETECTORS, DETECTORS, REFERENCE_DETECTORS
from seamark.sim.trackers.declaration import Errors, OptionValues

__all__ = [
    "MOST",
    "Corners",
    "Detection",
    "Detector",
    "DetectorDeclaration",
    "Image",
    "declaration",
    "make",
    "option_errors",
    "option_names",
    "warm_up",
]

_EVERY = DETECTORS | REFERENCE_DETECTORS | BOX_DETECTORS


def declaration(name: str) -> DetectorDeclaration:
    """Return the declaration of a detector: of any kind, also of marks on a leaderboard.

    Raises
    ------
    KeyError
        If there is none of that name.
    """
    declared: DetectorDeclaration = resolve_name(_EVERY[name])
    return declared


def option_names(name: str) -> tuple[str, ...]:
    """Return the names of a detector's options; unknown detectors have none."""
    return declaration(name).option_names if name in DETECTORS | BOX_DETECTORS else ()


def option_errors(name: str, values: OptionValues) -> Errors:
    """Return option -> why the detector does not accept it; empty if all is well."""
    return declaration(name).errors(values)


def make(name: str, **options: object) -> Detector:
    """Return a new detector.

    Parameters
    ----------
    name : str
        One of the registry's DETECTORS, REFERENCE_DETECTORS or BOX_DETECTORS.
    options
        Those that the detector declares; others are errors, so that none is silently ignored.

    Raises
    ------
    ValueError
        If the name or an option is not supported; the text says why.
    """
    if name not in _EVERY:
        raise ValueError(f"detector {name!r} must be one of {', '.join(DETECTORS)}")
    declared = declaration(name)
    if unknown := sorted(set(options) - set(declared.option_names)):
        raise ValueError(f"detector {name!r} has no option {', '.join(unknown)}")
    if errors := declared.errors(options):
        raise ValueError(" ".join(errors.values()))
    return declared.load()(**options)


def warm_up() -> None:
    """Load all compiled code, so that forked simulators start at once."""
    import_module("seamark.sim.detectors.warm_up").run()
