"""Where between pixels a peak is."""

import numpy as np
from numpy.typing import NDArray


def peak_offset(line: NDArray[np.float64], at: int) -> float:
    """Return the sub-pixel offset of the peak of a line, by a parabola, -0.5..0.5."""
    if not 0 < at < len(line) - 1:
        return 0.0
    before, top, after = line[at - 1 : at + 2]
    curvature = before - 2.0 * top + after
    return (
        0.0 if curvature >= 0.0 else float(np.clip(0.5 * (before - after) / curvature, -0.5, 0.5))
    )
