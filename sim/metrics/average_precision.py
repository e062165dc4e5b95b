"""Precision and recall of answers that have a confidence.

Answers that are ignored are in none of these arrays. Hits are at most as many as the objects.
"""

import math
from typing import NamedTuple

import numpy as np

from seamark.sim.numerics.arrays import Array, Flags, Integers
from seamark.sim.numerics.statistics import mean

RECALLS = np.linspace(0.0, 1.0, 101)  # S: COCO (Lin et al. 2014), with the bits that it has there


class Ranked(NamedTuple):
    """Answers in the order of their confidence, highest first; equal ones as they came."""

    confidence: Array  # (n,)
    hits: Integers  # (n,) up to and including each answer
    false_alarms: Integers  # likewise

    @property
    def precision(self) -> Array:
        """Share of hits up to and including each answer, (n,)."""
        result: Array = self.hits / (self.hits + self.false_alarms)
        return result

    def at_thresholds(self) -> "Ranked":
        """Return the answers after which a threshold can lie: no other has the same confidence."""
        last = np.append(np.diff(self.confidence) != 0.0, True)[: len(self.confidence)]
        return Ranked(self.confidence[last], self.hits[last], self.false_alarms[last])


def ranked(confidence: Array, hit: Flags) -> Ranked:
    """Return answers in their order.

    Parameters
    ----------
    confidence : (n,)
    hit : (n,) of bool
        Whether each is a hit; else it is a false alarm.
    """
    order = np.argsort(-confidence, kind="stable")
    hits = np.cumsum(hit[order], dtype=np.int64)
    return Ranked(confidence[order], hits, np.arange(1, len(order) + 1) - hits)


def interpolated_precision(confidence: Array, hit: Flags, objects: int) -> Array:
    """Return the largest precision at or above each of `RECALLS`, (101,); 0 where none gets so far.

    `objects` is how many were to be found, at least one.
    """
    answers = ranked(confidence, hit)
    highest = np.maximum.accumulate(answers.precision[::-1])[::-1]
    first = np.searchsorted(answers.hits / objects, RECALLS, side="left")
    result: Array = np.append(highest, 0.0)[first]
    return result


def average_precision(confidence: Array, hit: Flags, objects: int) -> float:
    """Return the mean interpolated precision, 0 to 1; nan if there was nothing to be found."""
    if objects == 0:
        return math.nan
    return mean(interpolated_precision(confidence, hit, objects).tolist())
