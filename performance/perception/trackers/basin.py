"""Convergence on photographs: how far targets may move, and how precise the corners are.

Every tracker gets the same images. A jump is never a loss here (`max_jump`), so that the trackers'
alignment is compared and not what each reports.
"""

from collections.abc import Iterable
from dataclasses import replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from performance.perception.trackers.contenders import (
    VERSION_1,
    VERSION_2,
    Contender,
    available,
    visp,
)
from performance.perception.trackers.photographs import (
    SIGMAS_PX,
    TURNED_PX,
    Displaced,
    displaced,
    turning,
)
from performance.perception.trackers.race import Result, race, rms_px, timed, tracker
from performance.perception.trackers.sequences import turning_box
from seamark.sim.camera import CURRENTS, VISIBILITY
from seamark.sim.camera.pictures import PHOTOGRAPHS

EACH = 12  # displacements of each photograph
WITHIN_PX = 1.0  # as in Baker & Matthews: root mean square over the corners
LARGEST_JUMP = 10.0
BOX_HEIGHTS_M = (1.27, 1.6, 1.8, 2.0, 2.27, 3.0)
BOX_SEEDS = range(3)

OURS = Contender("ours ZNCC ESM, second versions", "esm", VERSION_2)
FIRST = Contender("ours ZNCC ESM, first versions", "esm", VERSION_1)
ECC = Contender("OpenCV ECC", "ecc", {"max_jump": LARGEST_JUMP})
_VISP = tuple(
    visp(criterion, method, "homography", pyramid_levels=levels)
    for criterion, method, levels in (
        ("ssd", "esm", 1),
        ("ssd", "esm", 2),
        ("ssd", "esm", 3),
        ("ssd", "inverse_compositional", 2),
        ("zncc", "inverse_compositional", 1),
    )
)
CONTENDERS = (
    OURS,
    FIRST,
    *(replace(one, options=one.options | {"max_jump": LARGEST_JUMP}) for one in _VISP),
    ECC,
)


def capture(contender: Contender, cases: Iterable[Displaced]) -> tuple[float, float]:
    """Return the share of targets found within WITHIN_PX [%], and the median CPU time [us]."""
    running, good, spent = tracker(contender), [], []
    for case in cases:
        running.start(case.first, case.before)
        corners, us = timed(running, case.second)
        good.append(rms_px(corners, case.after) < WITHIN_PX)
        spent.append(us)
    return 100.0 * float(np.mean(good)), float(np.median(spent))


def photographs_px(contender: Contender) -> NDArray[np.float64]:
    """Return the errors [px] on turning photographs, the root mean square over each sequence."""
    sequences = (turning(name, *size) for name, size in product(PHOTOGRAPHS, TURNED_PX))
    return np.array([_rms(race((contender,), each)[0]) for each in sequences])


def boxes_px(contender: Contender) -> NDArray[np.float64]:
    """Return the errors [px] on a turning box: the median over the noise, for each height."""
    errors = [
        np.median([_rms(race((contender,), turning_box(optics, height, k))[0]) for k in BOX_SEEDS])
        for optics, height in product((VISIBILITY, CURRENTS), BOX_HEIGHTS_M)
    ]
    return np.array(errors)


def ratio(errors: NDArray[np.float64], reference: NDArray[np.float64]) -> float:
    """Return the geometric mean of the ratios of errors."""
    return float(np.exp(np.log(errors / reference).mean()))


def _rms(result: Result) -> float:
    return float(np.sqrt(np.mean(np.square(result.errors_px))))


def basin_table() -> str:
    """Measure; return a Markdown table of the targets found, and of the times."""
    heads = [f"σ {sigma:g} px" for sigma in SIGMAS_PX]
    lines = [
        "| tracker | " + " | ".join(heads) + f" | µs at {heads[1]} |",
        "|---|" + "--:|" * (len(heads) + 1),
    ]
    every = {sigma: tuple(displaced(sigma, each=EACH)) for sigma in SIGMAS_PX}
    for contender in available(CONTENDERS):
        results = [capture(contender, cases) for cases in every.values()]
        shares = " | ".join(f"{share:.0f} %" for share, _ in results)
        label = ", ".join(filter(None, (contender.label, contender.setup)))
        lines.append(f"| {label} | {shares} | {results[1][1]:.0f} |")
    return "\n".join(lines)


def turning_table() -> str:
    """Measure; return a Markdown table of the errors on turning targets, relative to ECC."""
    lines = [
        "| tracker | photographs px | ratio to ECC | box px | ratio to ECC |",
        "|---|--:|--:|--:|--:|",
    ]
    references = (photographs_px(ECC), boxes_px(ECC))
    for contender in (OURS, FIRST, ECC):
        cells = []
        for measure, reference in zip((photographs_px, boxes_px), references, strict=True):
            errors = measure(contender)
            cells += [f"{np.median(errors):.3f}", f"{ratio(errors, reference):.2f}"]
        lines.append(f"| {contender.label} | " + " | ".join(cells) + " |")
    return "\n".join(lines)
