"""The measured cases: trackers, motions and targets, by group."""

from collections.abc import Mapping
from typing import NamedTuple

from seamark.sim.settings.targets import TARGETS
from seamark.sim.trackers.options import CRITERIA, METHODS, WARPS

SEEDS, STEP, LEVEL_S = 10, 0.25, 5.0  # as in a ranked run; step in optical depth, duration in s
SHORTEST_S = 2.0  # shortest level allowed; for trackers that take 5 to 200 ms per image


class Case(NamedTuple):
    """One tracker in one experiment."""

    label: str
    config: Mapping[str, object]
    level_s: float = LEVEL_S


def _ours(criterion: str, warp: str) -> Case:
    return Case(f"esm {criterion} {warp}", {"criterion": criterion, "warp": warp})


def _opencv(tracker: str, warp: str) -> Case:
    return Case(f"{tracker} {warp}", {"tracker": tracker, "warp": warp})


def _visp(criterion: str, method: str, warp: str = "homography", **more: object) -> Case:
    """Return a case for ViSP, set up as in `perception/trackers`."""
    config: dict[str, object] = {
        "tracker": "visp",
        "criterion": criterion,
        "method": method,
        "warp": warp,
        "sampling_px": 2,
        "pyramid_levels": 2 if criterion == "ssd" else 1,
        "visp_iterations": {"ssd": 200, "zncc": 60, "mi": 30}[criterion],
    }
    return Case(f"visp {criterion} {_SHORT[method]} {warp}", config | more, SHORTEST_S)


_SHORT = {
    "esm": "esm",
    "inverse_compositional": "ic",
    "forward_additional": "fa",
    "forward_compositional": "fc",
}
# A path that every warp can follow: the vehicle stays level, at one height and heading.
IN_PLANE: dict[str, object] = {"path_turn_rad": 0.0, "path_heave_share": 0.0}
MARGIN = {"template_margin_px": 6}  # for a target that has nothing but its edges
ON_TARGETS: Mapping[str, Mapping[str, object]] = {
    "zncc": {"criterion": "zncc"},
    "ssd": {"criterion": "ssd"},
    "klt": {"tracker": "klt"},
}

GROUPS: Mapping[str, tuple[Case, ...]] = {
    "ours": tuple(_ours(criterion, warp) for criterion in CRITERIA for warp in WARPS)
    + tuple(
        Case(f"esm zncc homography, {_SHORT[method]}", {"method": method})
        for method in METHODS
        if method != "esm"
    ),
    "opencv": (
        *(_opencv("klt", warp) for warp in ("srt", "affine", "homography")),
        *(_opencv("ecc", warp) for warp in ("translation", "affine", "homography")),
        Case("box", {"tracker": "box"}),
        Case("kcf", {"tracker": "kcf"}),
        Case("csrt", {"tracker": "csrt"}),
    ),
    "visp": (
        *(_visp("ssd", "inverse_compositional", warp) for warp in ("translation", "rt", "srt")),
        *(_visp("zncc", "inverse_compositional", warp) for warp in ("translation", "srt")),
        _visp("zncc", "inverse_compositional"),
        _visp("zncc", "forward_additional"),
        *(_visp("ssd", method) for method in METHODS),
        _visp("mi", "inverse_compositional", "srt"),
        _visp("mi", "inverse_compositional"),
        _visp("mi", "forward_compositional"),
    ),
    "visp-slow": (
        _visp("mi", "inverse_compositional", sampling_px=1)._replace(
            label="visp mi ic homography, every pixel"
        ),
        _visp("mi", "forward_additional"),
        _visp("mi", "esm"),
    ),
    "in-plane": tuple(
        Case(f"{criterion} {warp}", IN_PLANE | {"criterion": criterion, "warp": warp})
        for criterion in CRITERIA
        for warp in WARPS
    ),
    "targets": tuple(
        Case(f"{name} on {target}", {"target": target, **config})
        for target in TARGETS
        if target != "lettered"  # the benchmark's own
        for name, config in ON_TARGETS.items()
    )
    + tuple(
        Case(f"{name} on plain, margin 6", {"target": "plain", **config, **MARGIN})
        for name, config in ON_TARGETS.items()
        if name != "klt"
    ),
}
