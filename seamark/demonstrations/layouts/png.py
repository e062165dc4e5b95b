"""Images as PNG, without loss, one for each new image."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seamark.demonstrations.episodes import Images


def packed_images(images: Mapping[str, Images], rate_hz: float) -> dict[str, NDArray[Any]]:
    """Return the PNGs of each camera behind each other, their sizes, and which are new when."""
    import cv2

    packed: dict[str, NDArray[Any]] = {}
    for camera, seen in images.items():
        files = [cv2.imencode(".png", frame)[1].ravel() for frame in seen.frames]
        packed[f"{camera}_png"] = np.concatenate(files)
        packed[f"{camera}_sizes"] = np.array([file.size for file in files])
        packed[f"{camera}_new"] = seen.is_new()
    return packed


def new_images(arrays: Mapping[str, NDArray[Any]], camera: str) -> list[bytes | None]:
    """Return the PNG of each observation; None where the image is that of the one before."""
    ends = np.cumsum(arrays[f"{camera}_sizes"])
    files = iter(np.split(arrays[f"{camera}_png"], ends[:-1]))
    return [next(files).tobytes() if new else None for new in arrays[f"{camera}_new"]]
