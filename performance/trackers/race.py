"""Runs all contenders over one sequence, some pictures each in turn, and keeps time and error."""

import time
from dataclasses import dataclass, field

import numpy as np

from performance.trackers.contenders import Contender
from performance.trackers.sequences import Sequence, carried
from seamark.sim.registry import TRACKERS
from seamark.sim.trackers import Tracker
from seamark.sim.trackers.choices import refusals

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
        end = min(first + TURN, len(sequence.pictures))
        for result, tracker in zip(results, trackers, strict=True):
            if result.lost_at is None:
                _turn(result, tracker, sequence, range(first, end))
    return results


def least(rounds: list[list[Result]]) -> list[Result]:
    """Return the results of the first of several equal races, each picture with its least time.

    What a neighbour on the same processor takes comes and goes within seconds, and doubles times.
    """
    for first, *others in zip(*rounds, strict=True):
        spent = zip(first.spent_us, *(other.spent_us for other in others), strict=True)
        first.spent_us = [min(each) for each in spent]
    return rounds[0]


def _made(contender: Contender) -> Tracker:
    made: Tracker = TRACKERS[contender.tracker].load()(**contender.options)
    return made


def _turn(result: Result, tracker: Tracker, sequence: Sequence, pictures: range) -> None:
    """Show some pictures one after the other; ViSP's time is its own part's, without the pipe.

    Each comes in the same memory, as from a camera that has just written it. Errors are computed
    afterwards: between the pictures that would drive the trackers' code out of the caches.
    """
    found = []
    picture = np.empty_like(sequence.pictures[0])
    for k in pictures:
        picture[:] = sequence.pictures[k]
        began = time.process_time_ns()
        track = tracker.update(picture)
        spent_us = (time.process_time_ns() - began) / 1e3
        own_s = getattr(tracker, "spent_s", None)
        found.append((k, track.corners, spent_us if own_s is None else 1e6 * own_s))
    for k, corners, spent_us in found:
        placed = carried(sequence.start_corners(), corners, sequence.corners[0])
        error = float(np.sqrt(((placed - sequence.corners[k]) ** 2).sum(axis=1).mean()))
        result.spent_us.append(spent_us)
        result.errors_px.append(error)
        if error > FAILED_PX:
            result.lost_at = k
            return
