"""Redraw the figures of docs/trackers.md: `./run performance tracker_figures [FOLDER]`."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from performance import FIGURES
from performance.figures.camera import Image
from performance.perception.trackers.sequences import HEIGHT_M
from performance.plots import figure
from seamark.sim.camera import VISIBILITY, Camera, Target, Water, start_pose
from seamark.sim.settings.tracker import ROBUST
from seamark.sim.trackers.options import CRITERIA, METHODS, WARPS
from seamark.sim.trackers.template.tracker import TemplateTracker

Corners = NDArray[np.float64]

TRUE, TRACKED, LOST = (90, 200, 90), (40, 120, 255), (60, 60, 230)  # BGR
SCALE = 16  # OpenCV draws to a sixteenth of a pixel (shift=4)
CROP = (slice(40, 200), slice(40, 280))
BOX = Target()  # of visibility-v1
START = start_pose(VISIBILITY, BOX, HEIGHT_M)
DEPTHS = (0.0, 2.0, 4.0, 5.5)
PX_M = VISIBILITY.focal_px / HEIGHT_M  # displacement of the target per metre sideways
DISTANCES_PX = range(0, 31, 2)
DIRECTIONS = 12
NEAR_PX = 1.0
BASINS: dict[str, dict[str, Any]] = {
    "1 level": {"pyramid_levels": 1},
    "2 levels": {"pyramid_levels": 2},
    "3 levels": {"pyramid_levels": 3},
    "2 levels and a second search": ROBUST,
}
STEPS = range(1, 13)
FIRST_PX, FIRST_RAD = 3.0, 0.05  # initial error of the iterations
CLOUD = range(12, 24)  # images in which a cloud of sediment hides the target
DRIFT_PX = 4.0  # of the target, per image


@dataclass(frozen=True, slots=True)
class Tracked:
    """An image with the tracker's result."""

    image: Image  # (H, W)
    true: Corners
    corners: Corners
    ok: bool

    def error_px(self) -> float:
        """Return the root mean square error over the corners."""
        return float(np.sqrt(((self.corners - self.true) ** 2).sum(axis=1).mean()))


def clear() -> Camera:
    """Return the camera in clear water."""
    return Camera(VISIBILITY, Water(), BOX, noise_seed=3)


def follow(
    poses: Iterable[NDArray[np.float64]],
    camera_at: Mapping[int, Camera] | Camera,
    **options: Any,
) -> list[Tracked]:
    """Return the template tracker's results for all images after the first, clear one."""
    tracker, results = TemplateTracker(**options), []
    for k, pose in enumerate(poses):
        camera = camera_at if isinstance(camera_at, Camera) else camera_at[k]
        true = camera.corners(pose)
        if k == 0:
            tracker.start(clear().grey(pose, 0), true)
            continue
        image = camera.grey(pose, k)
        track = tracker.update(image)
        results.append(Tracked(image, true, track.corners.copy(), track.ok))
    return results


def tile(result: Tracked, caption: str) -> Image:
    """Return the image (H, W, 3) with true and tracked corners and a caption."""
    drawn = cv2.cvtColor(result.image, cv2.COLOR_GRAY2BGR)
    for corners, colour in ((result.true, TRUE), (result.corners, TRACKED if result.ok else LOST)):
        points = np.round(corners * SCALE).astype(np.int32)[:, None]
        cv2.polylines(drawn, [points], isClosed=True, color=colour, lineType=cv2.LINE_AA, shift=4)
    part: Image = np.array(drawn[CROP], dtype=np.uint8)
    part[:18] //= 3  # dark band behind the white caption
    text = caption + ("" if result.ok else " LOST")
    white = (255, 255, 255)
    cv2.putText(part, text, (4, 13), cv2.FONT_HERSHEY_SIMPLEX, 0.4, white, 1, cv2.LINE_AA)
    return part


def rising() -> list[NDArray[np.float64]]:
    """Return poses of a vehicle that rises by half a metre while it turns and tilts."""
    motion = np.array([0.08, 0.05, -0.5, 0.10, 0.08, 0.35])
    return [START + share * motion for share in np.linspace(0.0, 1.0, 81)]


def warps() -> Image:
    """Return the last image of the ascent with each warp's result, after the first image."""
    poses = rising()
    first = follow(poses[:2], clear())[0]
    tiles = [tile(first, "at the start")]
    for warp in WARPS:
        last = follow(poses, clear(), warp=warp)[-1]
        tiles.append(tile(last, f"{warp}: {last.error_px():.2f} px"))
    return sheet(tiles, columns=3)


def criteria() -> Image:
    """Return images in increasingly turbid water, one row per criterion."""
    poses = [START + np.array([0.002 * k, 0.001 * k, 0, 0, 0, 0.002 * k]) for k in range(21)]
    tiles = []
    for criterion in CRITERIA:
        for depth in DEPTHS:
            camera = Camera(VISIBILITY, Water.grey(depth / HEIGHT_M), BOX, noise_seed=3)
            last = follow(poses, camera, criterion=criterion)[-1]
            error = f" {last.error_px():.2f} px" if last.ok else ""
            tiles.append(tile(last, f"{criterion}, tau {depth:g}:{error}"))
    return sheet(tiles, columns=len(DEPTHS))


def sheet(tiles: list[Image], *, columns: int) -> Image:
    """Return the tiles in rows."""
    rows = [np.hstack(tiles[k : k + columns]) for k in range(0, len(tiles), columns)]
    return np.asarray(np.vstack(rows), dtype=np.uint8)


def moved(distance_px: float, *, turn_rad: float = 0.0, **options: Any) -> list[Tracked]:
    """Return the results for targets that move this far between two images, in all directions."""
    results = []
    for k in range(DIRECTIONS):
        angle = 2.0 * np.pi * k / DIRECTIONS
        shift = distance_px / PX_M * np.array([np.cos(angle), np.sin(angle)])
        step = np.array([*shift, 0.0, 0.0, 0.0, turn_rad])
        results += follow([START, START + step], clear(), search_px=60, **options)
    return results


def basin(out: Path) -> None:
    """Draw how far a target may move between two images, by levels and with a second search."""
    with figure(out) as axes:
        for label, options in BASINS.items():
            shares = []
            for px in DISTANCES_PX:
                good = [a.ok and a.error_px() < NEAR_PX for a in moved(px, **options)]
                shares.append(100.0 * sum(good) / len(good))
            axes.plot(list(DISTANCES_PX), shares, label=label, marker=".")
        axes.set_xlabel("displacement of the target between two images [px]")
        axes.set_ylabel(f"found within {NEAR_PX:g} px [%]")
        axes.legend()


def iterations(out: Path) -> None:
    """Draw how the error decreases with each iteration of a method, on one pyramid level."""
    with figure(out) as axes:
        for name, label in METHODS.items():
            options: dict[str, Any] = {"method": name, "pyramid_levels": 1, "stop_px": 0.0001}
            errors = [
                np.median(
                    [
                        one.error_px()
                        for one in moved(FIRST_PX, turn_rad=FIRST_RAD, fine_iterations=n, **options)
                    ]
                )
                for n in STEPS
            ]
            axes.semilogy(list(STEPS), errors, label=label, marker=".")
        axes.set_xlabel("maximum number of iterations")
        axes.set_ylabel("median corner error [px]")
        axes.legend()


def cloud() -> Image:
    """Return images of a target that drifts behind a cloud, without and with re-acquisition."""
    poses = [START + np.array([0, (60 - k * DRIFT_PX) / PX_M, 0, 0, 0, 0]) for k in range(30)]
    turbid = Camera(VISIBILITY, Water.grey(8.0 / HEIGHT_M), BOX, noise_seed=3)
    cameras = {k: turbid if k in CLOUD else clear() for k in range(len(poses))}
    tiles = []
    for reach in (0, 120):
        results = follow(poses, cameras, reacquire_px=reach)
        for k in (CLOUD.start - 1, CLOUD.start + 4, CLOUD.stop + 1, len(poses) - 1):
            tiles.append(tile(results[k - 1], f"reacquire_px {reach}, image {k}"))
    return sheet(tiles, columns=4)


def main(arguments: Sequence[str]) -> int:
    """Write the figures."""
    folder = Path(*arguments) if arguments else FIGURES
    sheets: dict[str, Callable[[], Image]] = {
        "warps": warps,
        "criteria": criteria,
        "cloud": cloud,
    }
    for name, draw in sheets.items():
        coarse = draw() // 8 * 8 + 4  # without the low bits of the noise: a third of the size
        path = folder / f"trackers-{name}.png"
        cv2.imwrite(str(path), coarse, [cv2.IMWRITE_PNG_COMPRESSION, 9])
    basin(folder / "trackers-basin.png")
    iterations(folder / "trackers-iterations.png")
    return 0
