"""The published offset of about -5 px on Y: what reproduces it here, and what does not."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from performance.simulator.validation.trials import PAPER_VEHICLE, SEED, configured, moved_level
from performance.tables import markdown_table, signed
from seamark.sim.camera.optics import CURRENTS, MOUNT_M, VISIBILITY, Optics
from seamark.sim.camera.target import Target
from seamark.sim.recording.telemetry import INDEX, Rows

PUBLISHED_PX = -5.0
LATE_S = 30.0
STILL: Mapping[str, Any] = {
    "vehicle": PAPER_VEHICLE,
    "levels": (0.0,),
    "level_duration_s": 60.0,
    "settle_s": 30.0,
}
VISIBILITY_HEIGHT_M = 1.27  # S: UWSim visionBenchmarkScene.xml
VISIBILITY_AT_PX = (98.0, 43.0)  # S: its constant ground truth, right of and below the centre


def late_y(rows: Rows) -> float:
    """Return the mean Y error [px] over the last LATE_S."""
    t = rows[:, INDEX["t"]]
    return float(rows[t >= t[-1] - LATE_S, INDEX["error_y_px"]].mean())


def offset(controller: str, *, shift_px: float = 0.0, **values: Any) -> float:
    """Return the Y error [px] at which a controller settles.

    `shift_px` is the offset of all corners at which the tracker is initialised.
    """
    corners = np.tile([0.0, shift_px], (4, 1))
    return late_y(moved_level(controller, corners_px=corners, **{**STILL, **values}))


def projected(
    points: NDArray[np.float64], camera: NDArray[np.float64], focal: float
) -> NDArray[np.float64]:
    """Return the image of points in a level camera heading north, (k, 2) [px] from the centre."""
    away = points - camera
    return np.stack([focal * away[:, 1] / away[:, 2], -focal * away[:, 0] / away[:, 2]], axis=1)


def box_corners(target: Target) -> NDArray[np.float64]:
    """Return the target's eight corners, (8, 3) [m]."""
    top = target.top_corners()
    return np.concatenate([top, top + np.array([0.0, 0.0, target.height_m])])


def rectangle_shift(camera: NDArray[np.float64], target: Target) -> NDArray[np.float64]:
    """Return the bounding rectangle of all eight corners minus the top face, (4, 2) [px].

    The original initialises its tracker with that rectangle; visible sides make it larger.
    """
    focal = CURRENTS.focal_px
    seen = projected(box_corners(target), camera, focal)
    (left, upper), (right, lower) = seen.min(axis=0), seen.max(axis=0)
    around = np.array([[left, upper], [right, upper], [right, lower], [left, lower]])
    return around - projected(target.top_corners(), camera, focal)


def original_start(controller: str) -> float:
    """Return the Y error [px] for the start and both conventions of the original scene.

    The vehicle starts above the target, so its camera is off by the mounting offset; the tracker is
    initialised with the bounding rectangle of the whole box; the truth is the projected origin.
    """
    target, height = Target(), configured(**STILL).altitude_m
    camera = target.top_centre() + np.array([MOUNT_M[0], MOUNT_M[1], -height])
    return late_y(
        moved_level(
            controller,
            start_m=(MOUNT_M[0], MOUNT_M[1]),
            corners_px=rectangle_shift(camera, target),
            target_truth="uwsim",
            **STILL,
        )
    )


def parallax_share(height_m: float) -> float:
    """Return the parallax of the origin per pixel between target and image centre."""
    return 1.0 - height_m / (height_m + 0.5 * Target().height_m)


def visibility_parallax(optics: Optics = VISIBILITY) -> tuple[float, float]:
    """Return origin minus top centre in the original's static visibility view, (x, y) [px]."""
    target = Target()
    right, below = (px * VISIBILITY_HEIGHT_M / optics.focal_px for px in VISIBILITY_AT_PX)
    camera = target.top_centre() + np.array([below, -right, -VISIBILITY_HEIGHT_M])
    points = np.stack([target.origin(), target.top_centre()])
    origin, top = projected(points, camera, optics.focal_px).tolist()
    return origin[0] - top[0], origin[1] - top[1]


def text() -> str:
    """Return the text of the finding."""
    height = configured(**STILL).altitude_m
    needed = abs(PUBLISHED_PX) / parallax_share(height)
    side = visibility_parallax()
    held = {law: offset(law) for law in ("p", "pi")}
    uwsim = {law: offset(law, target_truth="uwsim") for law in held}
    original = {law: original_start(law) for law in held}
    shifted = {law: offset(law, shift_px=abs(PUBLISHED_PX)) for law in held}
    strong = {
        law: offset(law, shift_px=abs(PUBLISHED_PX), levels=(0.4,)) - offset(law, levels=(0.4,))
        for law in held
    }
    rows = [
        (what, signed(offsets["p"], 2), signed(offsets["pi"], 2))
        for what, offsets in (
            ("truth is the centre of the top face (ours)", held),
            ("truth is the projected origin of the box (`target_truth=uwsim`)", uwsim),
            ("as above, with the original scene's start and initial tracker rectangle", original),
            ("tracker initialised 5 px off on Y", shifted),
            ("the same at 0.4 m/s: change relative to an exact initialisation", strong),
        )
    ]
    return "\n\n".join(
        [
            "**Not reproduced by default, and the ground-truth convention alone does not explain "
            "it.** Mean Y error in px over the last 30 s of a minute in still water:",
            markdown_table(("change", "P", "PI"), rows),
            "The projected origin lies below the top face, so it differs from the visible centre "
            f"by parallax: {100.0 * parallax_share(height):.1f} % of the distance from the image "
            "centre. A station keeper brings the target to the centre, where this vanishes; 5 px "
            f"would need a target {needed:.0f} px away. In the original's static visibility view "
            f"(target {VISIBILITY_AT_PX[0]:g} px right and {VISIBILITY_AT_PX[1]:g} px below the "
            f"centre at {VISIBILITY_HEIGHT_M:g} m) the convention does give {side[0]:.1f} px on X "
            f"and {side[1]:.1f} px on Y with a perfect tracker: it matters there, but not here. "
            "What reproduces the published figure, for P and PI alike and at every level, is the "
            "paper's own explanation: a tracker that is 5 px off guides the vehicle to that "
            "offset. Our tracker is initialised at the true corners and stays within a tenth of a "
            "pixel of them, so it has no such offset; the figure does not show where the offset "
            f"of the authors' tracker came from. (Seed {SEED}, tracker `esm`.)",
        ]
    )
