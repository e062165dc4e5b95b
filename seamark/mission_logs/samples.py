"""What was read from a log, before its time is checked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Values = NDArray[np.float64]  # (n,)
ROWS_MAX = 500_000  # of one log: seven hours at 20 Hz


@dataclass(frozen=True, kw_only=True)
class Samples:
    """Values that were measured together, such as the lines of a CSV or the messages of a topic.

    `values` are in the units of the telemetry, in the frame of the log; `stamps` in s. `numbers`
    are those of the lines or messages, by which sentences name them.
    """

    label: str
    noun: str  # of a number: "line" or "message"
    stamps: Values
    numbers: NDArray[np.int64]
    values: Mapping[str, Values]

    def named(self, at: int) -> str:
        """Return what a sentence calls one sample."""
        return f"{self.noun} {self.numbers[at]}"
