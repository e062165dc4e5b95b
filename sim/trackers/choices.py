"""What the forms offer for trackers, and which combinations are refused, with the reason.

Light: importing this loads neither Numba nor OpenCV.
"""

from collections.abc import Mapping

from seamark.sim.registry import TRACKERS, TRUTH
from seamark.sim.trackers import visp

WARPS = {
    "translation": "Translation (2 parameters)",
    "rt": "Rotation and translation (3)",
    "srt": "Scale, rotation and translation (4)",
    "affine": "Affine (6)",
    "homography": "Homography (8)",
}
CRITERIA = {
    "zncc": "Zero-mean normalised cross-correlation",
    "ssd": "Sum of squared differences",
    "mi": "Mutual information",
}
METHODS = {
    "esm": "Efficient second-order minimisation",
    "inverse_compositional": "Inverse compositional",
    "forward_additional": "Forward additional",
    "forward_compositional": "Forward compositional",
}
KLT_FROM = {"first": "The first picture", "previous": "The picture before"}
_TABLES = {"warp": WARPS, "criterion": CRITERIA, "method": METHODS, "klt_from": KLT_FROM}
# Of numbers: allowed range of each option, the ends included.
RANGES: dict[str, tuple[float, float]] = {
    "pyramid_levels": (1, 4),
    "coarse_iterations": (0, 100),
    "fine_iterations": (1, 100),
    "stop_px": (0.0001, 2),
    "sampling_px": (1, 4),
    "template_margin_px": (-3, 40),
    "search_px": (4, 200),
    "reacquire_px": (0, 400),
    "klt_points": (8, 1000),
    "ecc_iterations": (1, 200),
    "visp_iterations": (1, 1000),
}


# Warps that a tracker does not have, with the reason.
_WITHOUT = {
    "klt": (
        ("translation", "rt"),
        "OpenCV fits no rotation and translation without a scale to points: "
        "choose srt, affine or homography",
    ),
    "ecc": (
        ("srt",),
        "OpenCV's ECC has no warp with one scale: choose rt, affine or homography",
    ),
}


def options_of(tracker: str) -> tuple[str, ...]:
    """Return the names of a tracker's options; ground truth has none."""
    return () if tracker == TRUTH else TRACKERS[tracker].options


def refusals(tracker: str, options: Mapping[str, object]) -> dict[str, str]:
    """Return option -> why the tracker does not take it; empty if all is well.

    Looks at the values and at combinations of them, for the options that the tracker has.
    """
    errors: dict[str, str] = {}
    for name in options_of(tracker):
        if name in options and (reason := _refusal(name, options[name])):
            errors[name] = reason
    if tracker in _WITHOUT and options.get("warp") in _WITHOUT[tracker][0]:
        why = _WITHOUT[tracker][1]
        errors["warp"] = f"warp {options['warp']} does not go with {tracker}: {why}."
    if tracker == "visp":
        errors |= _visp(options)
    return errors


def _refusal(name: str, value: object) -> str:
    if name in _TABLES and value not in _TABLES[name]:
        return f"{name} {value!r} is not offered: choose one of {', '.join(_TABLES[name])}."
    if name in RANGES:
        low, high = RANGES[name]
        if not (isinstance(value, int | float) and low <= value <= high):
            return f"{name} must be from {low:g} to {high:g}, not {value!r}."
    return ""


def _visp(options: Mapping[str, object]) -> dict[str, str]:
    """Return what ViSP does not have, beginning with ViSP itself."""
    if reason := visp.why_not():
        return {"tracker": f"tracker visp is not offered: {reason}."}
    errors: dict[str, str] = {}
    method = options.get("method", "inverse_compositional")
    if options.get("criterion") == "zncc" and method in ("esm", "forward_compositional"):
        errors["criterion"] = (
            f"criterion zncc does not go with {method} in ViSP: it has zncc as "
            "inverse_compositional and forward_additional alone."
        )
    warp = options.get("warp", "homography")
    sl3 = warp == "homography" and options.get("visp_sl3", True)
    if method == "esm" and warp != "translation" and not sl3:
        errors["method"] = (
            "method esm in ViSP takes the warps translation and homography (SL3) alone, "
            f"not {warp}."
        )
    return errors
