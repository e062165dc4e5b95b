"""The published offset of about -5 px on Y: what gives it in this simulator, and what does not."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from performance.validation.markdown import signed, table
from performance.validation.trials import PAPER_VEHICLE, SEED, configured, moved_level
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
VISIBILITY_AT_PX = (98.0, 43.0)  # S: the constant ground truth there, right and below the centre


def late_y(rows: Rows) -> float:
    """Return the mean Y error [px] of the last part."""
    t = rows[:, INDEX["t"]]
    return float(rows[t >= t[-1] - LATE_S, INDEX["error_y_px"]].mean())


def offset(controller: str, *, shift_px: float = 0.0, **values: Any) -> float:
    """Return the Y error [px] at which a controller settles.

    `shift_px` moves all corners that the tracker starts from.
    """
    corners = np.tile([0.0, shift_px], (4, 1))
    return late_y(moved_level(controller, corners_px=corners, **{**STILL, **values}))


def pictured(
    points: NDArray[np.float64], camera: NDArray[np.float64], focal: float
) -> NDArray[np.float64]:
    """Return where a level camera that heads north sees points, (k, 2) [px] from the centre."""
    away = points - camera
    return np.stack([focal * away[:, 1] / away[:, 2], -focal * away[:, 0] / away[:, 2]], axis=1)


def box_corners(target: Target) -> NDArray[np.float64]:
    """Return the target's eight corners, (8, 3) [m]."""
    top = target.top_corners()
    return np.concatenate([top, top + np.array([0.0, 0.0, target.height_m])])


def rectangle_shift(camera: NDArray[np.float64], target: Target) -> NDArray[np.float64]:
    """Return how the rectangle around all eight corners differs from the top face, (4, 2) [px].

    It is what the original gives a tracker to start from: sides that show make it larger.
    """
    focal = CURRENTS.focal_px
    seen = pictured(box_corners(target), camera, focal)
    (left, upper), (right, lower) = seen.min(axis=0), seen.max(axis=0)
    around = np.array([[left, upper], [right, upper], [right, lower], [left, lower]])
    return around - pictured(target.top_corners(), camera, focal)


def original_start(controller: str) -> float:
    """Return the Y error [px] for the original scene's start and both of its conventions.

    The vehicle starts above the target, its camera therefore beside it by the mount; the tracker
    starts from the rectangle around the whole box; the truth is the projected origin.
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
    """Return the origin's parallax per pixel that the target is off the centre."""
    return 1.0 - height_m / (height_m + 0.5 * Target().height_m)


def visibility_parallax(optics: Optics = VISIBILITY) -> tuple[float, float]:
    """Return origin minus top centre in the original's static visibility view, (x, y) [px]."""
    target = Target()
    right, below = (px * VISIBILITY_HEIGHT_M / optics.focal_px for px in VISIBILITY_AT_PX)
    camera = target.top_centre() + np.array([below, -right, -VISIBILITY_HEIGHT_M])
    points = np.stack([target.origin(), target.top_centre()])
    origin, top = pictured(points, camera, optics.focal_px).tolist()
    return origin[0] - top[0], origin[1] - top[1]


def text() -> str:
    """Return the fact's text."""
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
        (what, signed(found["p"], 2), signed(found["pi"], 2))
        for what, found in (
            ("truth is the centre of the top face (ours)", held),
            ("truth is the projected origin of the box (`target_truth=uwsim`)", uwsim),
            ("that, the original scene's start, tracker begun around all eight corners", original),
            ("tracker begun 5 px off on Y", shifted),
            ("the same at 0.4 m/s: change against an unshifted start", strong),
        )
    ]
    return "\n\n".join(
        [
            "**Not reproduced by itself, and the ground-truth convention alone does not explain "
            "it.** Means of the Y error in px over the last 30 s of a minute in still water:",
            table(("what is changed", "P", "PI"), rows),
            "The projected origin lies below the top face, so it differs from the visible centre "
            f"by parallax: {100.0 * parallax_share(height):.1f} % of the distance from the image's "
            "centre. A station keeper brings the target to the centre, where that is nothing; 5 px "
            f"would need a target {needed:.0f} px away. In the original's static visibility view "
            f"(target {VISIBILITY_AT_PX[0]:g} px right and {VISIBILITY_AT_PX[1]:g} px below the "
            f"centre at {VISIBILITY_HEIGHT_M:g} m) the convention does give {side[0]:.1f} px on X "
            f"and {side[1]:.1f} px on Y, with a perfect tracker: there it matters, here it does "
            "not. What gives the published picture, for P and PI alike and at every level, is what "
            "the paper itself says: a tracker that is 5 px off and guides the vehicle there. Our "
            "tracker is begun at the true corners and stays within a tenth of a pixel of them, so "
            "it has no such offset; where the authors' tracker had its own from cannot be told "
            f"from the figure. (Seed {SEED}, tracker `esm`.)",
        ]
    )
