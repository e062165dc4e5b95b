"""Runs all contenders over one sequence, some pictures each in turn, and keeps time and error."""

import time
from dataclasses import dataclass, field

import numpy as np

from performance.trackers.contenders import Contender
from performance.trackers.sequences import Sequence, carried
from sim.registry import TRACKERS
from sim.trackers import Tracker
from sim.trackers.choices import refusals

TURN = 30  # pictures: long enough that each finds its own code and data in the caches
FAILED_PX = 10.0  # S: Lieberknecht et al., ISMAR 2009: a picture with more has failed


@dataclass(slots=True)
class Result:
    """One contender on one sequence."""

    contender: Contender
    errors_px: list[float] = field(default_factory=list)  # root mean square over the corners
    spent_us: list[float] = field(default_factory=list)  # CPU time
    lost_at: int | None = None  # the first failed picture; none after it is shown

    def median_us(self) -> float:
        """Return the median CPU time of a picture."""
        return float(np.median(self.spent_us))

    def error(self, percentile: float) -> float:
        """Return a percentile of the errors [px] of the pictures until it was lost."""
        kept = self.errors_px[: self.lost_at] if self.lost_at is not None else self.errors_px
        return float(np.percentile(kept, percentile)) if kept else float("nan")


def race(contenders: tuple[Contender, ...], sequence: Sequence) -> list[Result]:
    """Return the results of those contenders that are on this machine.

    The contenders take turns of some pictures, so that a busy machine slows all alike.
    """
    results, trackers = [], []
    for contender in contenders:
        if not refusals(contender.tracker, contender.options):
            tracker = _made(contender)
            tracker.start(sequence.pictures[0].copy(), sequence.start_corners())
            results.append(Result(contender))
            trackers.append(tracker)
    for first in range(1, len(sequence.pictures), TURN):
        for result, tracker in zip(results, trackers, strict=True):
            for k in range(first, min(first + TURN, len(sequence.pictures))):
                if result.lost_at is None:
                    _one(result, tracker, sequence, k)
    return results


def _made(contender: Contender) -> Tracker:
    made: Tracker = TRACKERS[contender.tracker].load()(**contender.options)
    return made


def _one(result: Result, tracker: Tracker, sequence: Sequence, k: int) -> None:
    """Show one picture; ViSP's time is that of its own part, without the pipe."""
    began = time.process_time_ns()
    track = tracker.update(sequence.pictures[k])
    spent_us = (time.process_time_ns() - began) / 1e3
    own_s = getattr(tracker, "spent_s", None)
    result.spent_us.append(spent_us if own_s is None else 1e6 * own_s)
    found = carried(sequence.start_corners(), track.corners, sequence.corners[0])
    error = float(np.sqrt(((found - sequence.corners[k]) ** 2).sum(axis=1).mean()))
    result.errors_px.append(error)
    if error > FAILED_PX:
        result.lost_at = k
