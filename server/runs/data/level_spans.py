"""Where the levels of a run are among its rows."""

from itertools import pairwise

import numpy as np

from seamark.server.runs.data.downsampling import BLOCK_ROWS
from seamark.server.runs.data.files import RunFiles
from seamark.sim.recording.telemetry import INDEX

LEVEL_ROWS_MAX = 65_536  # 30 MB; those of the benchmarks have a tenth


def level_spans(files: RunFiles, *, ended: bool) -> list[tuple[int, int]]:
    """Return the ranges of rows of the completed levels of all trials.

    Without those of more than `LEVEL_ROWS_MAX` rows: they are shown when the run has metrics.
    """
    starts: list[int] = []
    count, before = files.row_count(), np.full((1, 2), np.nan)
    for at in range(0, count, BLOCK_ROWS):
        place = files.rows(at, min(at + BLOCK_ROWS, count))[:, [INDEX["trial"], INDEX["level"]]]
        begins = (np.diff(place, axis=0, prepend=before) != 0).any(axis=1)
        starts += (at + np.flatnonzero(begins)).tolist()
        before = place[-1:]
    spans = pairwise([*starts, count] if ended else starts)
    return [(first, after) for first, after in spans if after - first <= LEVEL_ROWS_MAX]
