"""Trackers that win without seeing: they play back what they stored.

Used by `headroom.visibility`, to show that it gains nothing.
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from seamark.sim.engine.trial import run_trial
from seamark.sim.recording.telemetry import INDEX, Rows
from seamark.sim.registry import benchmark
from seamark.sim.trackers.interface import Corners, Track, Tracker, Window

Image = NDArray[np.uint8]
Path = NDArray[np.float64]  # (images, 4, 2) [px] of one start of the tracker, the first included

NEAR_PX = 2.0  # from the corners of a start to those of a stored one that counts as the same
_CORNERS = slice(INDEX["corner_0"], INDEX["corner_7"] + 1)


class Playback:
    """Ignores every image: answers with the stored path that begins at the same corners."""

    def __init__(self, paths: Mapping[bytes, Path]) -> None:
        self._paths = paths
        self._path: Path = np.zeros((1, 4, 2))
        self._image = 0

    def start(self, image: Image, corners: Corners) -> None:
        """Look the corners up; an unknown start is played as a target that never moves."""
        self._path, self._image = self._paths.get(corners.tobytes(), corners[None]), 0

    def window(self) -> Window:
        """Return an empty window."""
        return 0, 0, 0, 0

    def update(self, image: Image) -> Track:
        """Return the next stored corners."""
        self._image += 1
        return Track(self._path[min(self._image, len(self._path) - 1)], True, 0.0, 0)


def stored_paths(name: str, *, seed: int, trials: int) -> dict[bytes, Path]:
    """Return the true path of every start in some trials, by the corners of the start."""
    entry = benchmark(name)
    config, oracle = entry.read({}), entry.load().built_in("oracle", entry.read({}))
    paths: dict[bytes, Path] = {}
    for trial in range(trials):
        kept: list[Rows] = []
        run_trial(name, config, oracle, seed=seed, trial=trial, on_rows=kept.append)
        rows = np.concatenate(kept)
        for level in range(len(config.level_values())):
            path = rows[rows[:, INDEX["level"]] == level][:, _CORNERS].reshape(-1, 4, 2)
            every = config.images_per_start(level) or len(path)
            for first in range(0, len(path), every):
                paths[path[first].tobytes()] = path[first : first + every]
    return paths


class Remembering:
    """An honest tracker that plays back what it saw on the same path in earlier levels.

    It falls back on its memory whenever the honest tracker reports a loss.
    """

    def __init__(self, honest: Tracker) -> None:
        self._honest = honest
        self._memories: list[tuple[Corners, dict[int, Corners]]] = []
        self._known: dict[int, Corners] = {}
        self._image = 0

    def start(self, image: Image, corners: Corners) -> None:
        """Recall the path that began here, if any."""
        self._honest.start(image, corners)
        self._image = 0
        for begin, known in self._memories:
            if np.abs(begin - corners).max() < NEAR_PX:
                self._known = known
                return
        self._known = {}
        self._memories.append((corners.copy(), self._known))

    def window(self) -> Window:
        """Return what the honest tracker needs."""
        return self._honest.window()

    def update(self, image: Image) -> Track:
        """Return what the honest tracker sees, or else what is remembered."""
        self._image += 1
        track = self._honest.update(image)
        if track.ok:
            self._known[self._image] = track.corners.copy()
            return track
        recalled = self._known.get(self._image)
        return track if recalled is None else Track(recalled, True, 0.0, 0)


class Always:
    """An honest tracker that never admits a loss: it then answers with the last corners."""

    def __init__(self, honest: Tracker) -> None:
        self._honest = honest

    def start(self, image: Image, corners: Corners) -> None:
        """Start the honest tracker."""
        self._honest.start(image, corners)

    def window(self) -> Window:
        """Return what the honest tracker needs."""
        return self._honest.window()

    def update(self, image: Image) -> Track:
        """Return what the honest tracker sees, or saw last."""
        return self._honest.update(image)._replace(ok=True)
