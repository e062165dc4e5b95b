"""Seamark's trackers on your own videos.

    from seamark.trackers import track

    corners = [(211, 98), (302, 101), (300, 131), (209, 128)]
    for found in track("dive.mp4", corners):
        print(found.number, found.time_s, found.ok, found.corners)

The trackers, their options and defaults are those of the newest benchmarks; see docs/trackers.md.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from seamark.sim.registry import TRACKERS
from seamark.sim.settings.tracker import RobustTrackerSettings
from seamark.sim.trackers import make, option_names

__all__ = ["TRACKERS", "Found", "VideoUnreadable", "track"]

Image = NDArray[np.uint8]
DEFAULTS = RobustTrackerSettings.model_fields
_CORNERS, _COLOURS = 4, 3


class VideoUnreadable(ValueError):
    """A file is no video that OpenCV can read, or has too few images."""


class Found(NamedTuple):
    """Where the target is in one image."""

    number: int  # of the image, from 0
    time_s: float  # in the video [s]; not a number for images that are no video
    corners: NDArray[np.float64]  # (4, 2) [px], the last valid ones if the target is lost
    ok: bool  # whether the tracker has the target
    residual: float  # 0 for a perfect match, 1 for no similarity, 2 for its inverse
    image: Image  # as it came: (H, W) grey, or (H, W, 3) blue, green, red


def track(
    video: str | Path | Iterable[Image],
    corners: Sequence[Sequence[float]] | NDArray[np.float64],
    *,
    tracker: str = "esm",
    first: int = 0,
    **options: object,
) -> Iterator[Found]:
    """Follow a plane target through a video, image by image.

    Parameters
    ----------
    video
        A file that OpenCV reads, or images of uint8: grey (H, W), or blue, green, red (H, W, 3).
        Colour images are made grey by their luminance.
    corners : (4, 2)
        The target's corners in the first image [px], x to the right and y down, clockwise.
    tracker
        One of `TRACKERS`.
    first
        Number of the image in which these are the corners; earlier ones are left out.
    options
        Of the tracker, such as `warp="affine"`: those of a benchmark's configuration.

    Yields
    ------
    Found
        The target in the first image and in each of the others.

    Raises
    ------
    FileNotFoundError
        There is no such file.
    VideoUnreadable
        It is no video, or ends before the first image.
    ValueError
        There is no such tracker or option, a value is not allowed, the corners are no convex
        quadrilateral of a size that can be tracked, or an image has another shape.
    """
    start = np.array(corners, dtype=np.float64)
    if start.shape != (_CORNERS, 2) or not np.isfinite(start).all():
        raise ValueError(f"there must be four corners (x, y), not an array of shape {start.shape}")
    if tracker not in TRACKERS:
        raise ValueError(f"tracker {tracker!r} must be one of {', '.join(TRACKERS)}")
    usual = {name: DEFAULTS[name].default for name in option_names(tracker)}
    chosen: dict[str, Any] = usual | options
    return _tracked(video, start, make(tracker, **chosen), first)


def _tracked(
    video: str | Path | Iterable[Image], start: NDArray[np.float64], tracker: Any, first: int
) -> Iterator[Found]:
    images = _images_of(Path(video)) if isinstance(video, str | Path) else _untimed(video)
    begun = False
    for number, (image, time_s) in enumerate(images):
        if number < first:
            continue
        grey = _grey(image)
        if begun:
            corners, ok, residual, _ = tracker.update(grey)
            yield Found(number, time_s, np.array(corners), bool(ok), float(residual), image)
        else:
            tracker.start(grey, start)
            begun = True
            yield Found(number, time_s, start.copy(), True, 0.0, image)
    if not begun:
        raise VideoUnreadable(f"there is no image {first} to start with")


def _images_of(path: Path) -> Iterator[tuple[Image, float]]:
    """Yield the images of a video and the times at which they are shown."""
    if not path.exists():
        raise FileNotFoundError(f"{path} does not exist")
    video = cv2.VideoCapture(str(path))
    try:
        if not video.isOpened():
            raise VideoUnreadable(f"{path} is no video that OpenCV can read")
        while True:
            there, image = video.read()
            if not there:
                return
            yield np.asarray(image, np.uint8), video.get(cv2.CAP_PROP_POS_MSEC) * 1e-3
    finally:
        video.release()


def _untimed(images: Iterable[Image]) -> Iterator[tuple[Image, float]]:
    for image in images:
        yield image, math.nan


def _grey(image: Image) -> Image:
    if image.dtype != np.uint8 or image.ndim not in (2, _COLOURS):
        raise ValueError(f"an image is (H, W) or (H, W, 3) of uint8, not {image.shape}")
    if image.ndim == _COLOURS:
        return np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), np.uint8)
    return np.array(image)  # trackers need one that they can write to
