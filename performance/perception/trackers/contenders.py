"""The trackers compared, with settings that are fair to each.

A cell of the table is a tuple of set-ups of one tracker; the fastest that keeps the target is
compared.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field

from seamark.sim.settings.tracker import ROBUST
from seamark.sim.trackers import option_errors

VERSION_1: dict[str, object] = {}  # of our tracker in the first versions of the benchmarks
VERSION_2: dict[str, object] = ROBUST
PYRAMID_LEVELS = (1, 2)
_METHODS = {
    "esm": "ESM",
    "inverse_compositional": "IC",
}
_ITERATIONS = {"ssd": 200, "zncc": 60, "mi": 30}


@dataclass(frozen=True, slots=True)
class Contender:
    """A tracker with its options."""

    label: str
    tracker: str
    options: dict[str, object] = field(default_factory=dict)
    predicts: bool = True  # whether the search starts where constant velocity leads
    setup: str = ""  # in what it differs from others of its cell


Cell = tuple[Contender, ...]


def available(contenders: Iterable[Contender]) -> list[Contender]:
    """Return the contenders that this machine can run."""
    return [one for one in contenders if not option_errors(one.tracker, one.options)]


def visp(
    criterion: str, method: str, warp: str, *, pyramid_levels: int, predicts: bool = False
) -> Contender:
    """Return one of ViSP's trackers.

    Sampling 2 is what ViSP's examples and UWSim use; its MI with a homography loses the target with
    it. In the bridge, its pyramid goes down to full resolution, its ESM gets the gain that undoes
    its half steps, and its template leaves out the target's rim as ours does: without any of these
    it would perform worse.
    """
    options: dict[str, object] = {
        "criterion": criterion,
        "method": method,
        "warp": warp,
        "sampling_px": 1 if (criterion, warp) == ("mi", "homography") else 2,
        "visp_iterations": _ITERATIONS[criterion],
        "pyramid_levels": pyramid_levels,
        "visp_predict": predicts,
    }
    label = f"ViSP {criterion.upper()} {_METHODS[method]} {warp}"
    levels = f"{pyramid_levels} pyramid level{'s' * (pyramid_levels > 1)}"
    return Contender(label, "visp", options, predicts, levels)


def _visp_cells(*kinds: tuple[str, str, str]) -> tuple[Cell, ...]:
    """Return the cells of ViSP's trackers, each without and with our prediction."""
    return tuple(
        tuple(visp(*kind, pyramid_levels=levels, predicts=predicts) for levels in PYRAMID_LEVELS)
        for kind in kinds
        for predicts in (False, True)
    )


def _ours(label: str, *, predicts: bool = True, **options: object) -> Cell:
    chosen = VERSION_2 | options | {"predict_motion": predicts}
    return (Contender(f"ours {label}", "esm", chosen, predicts),)


CELLS: tuple[Cell, ...] = (
    _ours("ZNCC ESM homography"),
    _ours("ZNCC ESM homography", predicts=False),
    (Contender("ours ZNCC ESM homography, first versions", "esm", VERSION_1),),
    _ours("SSD ESM homography", criterion="ssd"),
    _ours("MI ESM homography", criterion="mi"),
    _ours("ZNCC ESM affine", warp="affine"),
    _ours("ZNCC ESM srt", warp="srt"),
    *_visp_cells(
        ("ssd", "inverse_compositional", "homography"),
        ("ssd", "esm", "homography"),
        ("zncc", "inverse_compositional", "homography"),
        ("ssd", "inverse_compositional", "srt"),
    ),
    (Contender("OpenCV ECC homography", "ecc"),),
    (Contender("OpenCV ECC homography", "ecc", {"predict_motion": False}, predicts=False),),
    (Contender("OpenCV KLT homography", "klt", predicts=False),),
    (Contender("OpenCV KLT srt", "klt", {"warp": "srt"}, predicts=False),),
    (Contender("OpenCV box by correlation", "box", predicts=False),),
)
# Raced separately: 30 of their images take a second, after which fast trackers took twice as long.
SLOW_CELLS: tuple[Cell, ...] = (
    *(
        (visp("mi", "inverse_compositional", warp, pyramid_levels=1, predicts=predicts),)
        for warp in ("homography", "srt")
        for predicts in (False, True)
    ),
    (Contender("OpenCV CSRT", "csrt", predicts=False),),
    (Contender("OpenCV KCF", "kcf", predicts=False),),
)
PEERS = ("ViSP", "homography")  # start and end of the labels of the reference: the fastest of these
