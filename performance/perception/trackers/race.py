"""Runs all contenders over one sequence, in turns of some images, and records time and error."""

import time
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from performance.perception.trackers.contenders import Cell, Contender, available
from performance.perception.trackers.sequences import Sequence, transformed
from seamark.sim.trackers import Corners, Tracker, declaration

TURN = 30  # images: long enough for each to have its own code and data in the caches
FAILED_PX = 10.0  # S: Lieberknecht et al., ISMAR 2009: an image with a larger error has failed


@dataclass(slots=True)
class Result:
    """The result of one contender on one sequence."""

    contender: Contender
    errors_px: list[float] = field(default_factory=list)  # root mean square over the corners
    cpu_us: list[float] = field(default_factory=list)
    lost_at: int | None = None  # the first failed image; the contender gets none after it

    def median_us(self) -> float:
        """Return the median CPU time per image."""
        return float(np.median(self.cpu_us))

    def error(self, percentile: float) -> float:
        """Return a percentile of the errors [px] over the images before the loss."""
        kept = self.errors_px[: self.lost_at] if self.lost_at is not None else self.errors_px
        return float(np.percentile(kept, percentile)) if kept else float("nan")


def race(contenders: Iterable[Contender], sequence: Sequence) -> list[Result]:
    """Return the results of the contenders that are available on this machine.

    The contenders take turns of some images, so that a busy machine slows all alike.
    """
    results, trackers = [], []
    for contender in available(contenders):
        running = tracker(contender)
        running.start(sequence.images[0].copy(), sequence.start_corners())
        results.append(Result(contender))
        trackers.append(running)
    for first in range(1, len(sequence.images), TURN):
        end = min(first + TURN, len(sequence.images))
        for result, running in zip(results, trackers, strict=True):
            if result.lost_at is None:
                _turn(result, running, sequence, range(first, end))
    return results


def qualified(cells: Iterable[Cell], sequence: Sequence) -> list[Contender]:
    """Return of each cell the fastest set-up that keeps the target, or else the last to lose it."""
    chosen = []
    for cell in cells:
        usable = available(cell)
        if len(usable) > 1:
            usable = [min(race(usable, sequence), key=_rank).contender]
        chosen += usable
    return chosen


def _rank(result: Result) -> tuple[int, float]:
    """Return a key by which survivors come first, the fastest before all."""
    return (0, result.median_us()) if result.lost_at is None else (1, -result.lost_at)


def fastest(rounds: list[list[Result]]) -> list[Result]:
    """Return the results of the first of several equal races, each image with its shortest time.

    Load from neighbours on the same processor comes and goes within seconds and doubles times.
    """
    for first, *others in zip(*rounds, strict=True):
        times = zip(first.cpu_us, *(other.cpu_us for other in others), strict=True)
        first.cpu_us = [min(each) for each in times]
    return rounds[0]


def tracker(contender: Contender) -> Tracker:
    """Return a new tracker."""
    return declaration(contender.tracker).load()(**contender.options)


def timed(running: Tracker, image: NDArray[np.uint8]) -> tuple[Corners, float]:
    """Return a tracker's corners (4, 2) in the next image (H, W), and its CPU time [us].

    ViSP's time is that of its own process, without the pipe.
    """
    start = time.process_time_ns()
    track = running.update(image)
    cpu_us = (time.process_time_ns() - start) / 1e3
    own_s = getattr(running, "spent_s", None)
    return track.corners, cpu_us if own_s is None else 1e6 * own_s


def rms_px(corners: Corners, true: Corners) -> float:
    """Return the root mean square error over the corners (4, 2) [px]."""
    return float(np.sqrt(((corners - true) ** 2).sum(axis=1).mean()))


def _turn(result: Result, running: Tracker, sequence: Sequence, indices: range) -> None:
    """Pass some images to one tracker.

    Each image is written into the same memory, as by a camera. Errors are computed afterwards:
    between the images this would evict the trackers' code from the caches.
    """
    answers = []
    image = np.empty_like(sequence.images[0])
    for k in indices:
        image[:] = sequence.images[k]
        answers.append((k, *timed(running, image)))
    for k, corners, cpu_us in answers:
        target = transformed(sequence.start_corners(), corners, sequence.corners[0])
        error = rms_px(target, sequence.corners[k])
        result.cpu_us.append(cpu_us)
        result.errors_px.append(error)
        if error > FAILED_PX:
            result.lost_at = k
            return
