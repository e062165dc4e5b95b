"""What the forms offer for trackers, and which combinations are refused, with the reason.

Light: importing this loads neither Numba nor OpenCV.
"""

from collections.abc import Mapping

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
_TABLES = {"warp": WARPS, "criterion": CRITERIA, "method": METHODS}
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
}


def refusals(tracker: str, options: Mapping[str, object]) -> dict[str, str]:
    """Return option -> why the tracker does not take it; empty if all is well.

    `tracker` decides which combinations there are; options that it does not have are not looked at
    here.
    """
    errors: dict[str, str] = {}
    for name, value in options.items():
        if name in _TABLES and value not in _TABLES[name]:
            errors[name] = f"{name} {value!r} is not offered: choose one of " + ", ".join(
                _TABLES[name]
            )
        if name in RANGES:
            low, high = RANGES[name]
            if not (isinstance(value, int | float) and low <= value <= high):
                errors[name] = f"{name} is {value}; it must be {low:g}..{high:g}"
    return errors
