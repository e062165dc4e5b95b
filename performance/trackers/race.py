"""Runs all contenders over one sequence, in turns of some images, and records time and error."""

import time
from dataclasses import dataclass, field

import numpy as np

from performance.trackers.contenders import Contender
from performance.trackers.sequences import Sequence, transformed
from seamark.sim.trackers import Tracker, declaration, option_errors

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


def race(contenders: tuple[Contender, ...], sequence: Sequence) -> list[Result]:
    """Return the results of the contenders that are available on this machine.

    The contenders take turns of some images, so that a busy machine slows all alike.
    """
    results, trackers = [], []
    for contender in contenders:
        if not option_errors(contender.tracker, contender.options):
            tracker = _tracker(contender)
            tracker.start(sequence.images[0].copy(), sequence.start_corners())
            results.append(Result(contender))
            trackers.append(tracker)
    for first in range(1, len(sequence.images), TURN):
        end = min(first + TURN, len(sequence.images))
        for result, tracker in zip(results, trackers, strict=True):
            if result.lost_at is None:
                _turn(result, tracker, sequence, range(first, end))
    return results


def fastest(rounds: list[list[Result]]) -> list[Result]:
    """Return the results of the first of several equal races, each image with its shortest time.

    Load from neighbours on the same processor comes and goes within seconds and doubles times.
    """
    for first, *others in zip(*rounds, strict=True):
        times = zip(first.cpu_us, *(other.cpu_us for other in others), strict=True)
        first.cpu_us = [min(each) for each in times]
    return rounds[0]


def _tracker(contender: Contender) -> Tracker:
    return declaration(contender.tracker).load()(**contender.options)


def _turn(result: Result, tracker: Tracker, sequence: Sequence, indices: range) -> None:
    """Pass some images to one tracker; ViSP's time is that of its own process, without the pipe.

    Each image is written into the same memory, as by a camera. Errors are computed afterwards:
    between the images this would evict the trackers' code from the caches.
    """
    found = []
    image = np.empty_like(sequence.images[0])
    for k in indices:
        image[:] = sequence.images[k]
        start = time.process_time_ns()
        track = tracker.update(image)
        cpu_us = (time.process_time_ns() - start) / 1e3
        own_s = getattr(tracker, "spent_s", None)
        found.append((k, track.corners, cpu_us if own_s is None else 1e6 * own_s))
    for k, corners, cpu_us in found:
        target = transformed(sequence.start_corners(), corners, sequence.corners[0])
        error = float(np.sqrt(((target - sequence.corners[k]) ** 2).sum(axis=1).mean()))
        result.cpu_us.append(cpu_us)
        result.errors_px.append(error)
        if error > FAILED_PX:
            result.lost_at = k
            return
