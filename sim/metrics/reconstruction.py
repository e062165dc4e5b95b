"""The original benchmark module's metric of a 3-D reconstruction, for point clouds.

No benchmark uses it yet, as no run produces a point cloud.
"""

import math
from itertools import product

import numpy as np
from numpy.typing import NDArray

from seamark.sim.numerics.statistics import mean

Cloud = NDArray[np.float64]  # (n, 3) [m]
_CHUNK = 256  # points compared with all true ones at a time
_AROUND = tuple(product((-1, 0, 1), repeat=3))


def reconstruction(points: Cloud, truth: Cloud, *, level_of_detail: float) -> dict[str, float]:
    """Return how well points match a true surface, by an occupancy grid.

    Parameters
    ----------
    points, truth : (n, 3), (m, 3) [m]
        The reconstruction, and points that sample the true surface at least as densely as the grid.
    level_of_detail
        Side of a cell [m].

    Returns
    -------
    dict
        `meanError` [m] and `variance` [m²] of the distance to the nearest true point, over the
        points that are not outliers (nan without any); `coverage` [%]: share of the true cells that
        contain a point; `outliers` [%]: share of the points neither in a true cell nor next to one.

    Raises
    ------
    ValueError
        If a cloud is empty or not (n, 3), or the level of detail is not positive.
    """
    for name, cloud in (("points", points), ("truth", truth)):
        if cloud.ndim != 2 or cloud.shape[1] != 3 or not len(cloud):
            raise ValueError(f"{name} must have the shape (n, 3) with n > 0, not {cloud.shape}")
    if not level_of_detail > 0.0:
        raise ValueError(f"level_of_detail must be positive, not {level_of_detail:g}")
    mapped, wanted = _cells(points, level_of_detail), _cells(truth, level_of_detail)
    true_cells = set(wanted)
    near = {tuple(a + b for a, b in zip(c, o, strict=True)) for c in true_cells for o in _AROUND}
    inside = np.array([cell in near for cell in mapped])
    errors = _nearest(points[inside], truth)
    average = mean(errors)
    return {
        "meanError": average,
        "variance": mean([(error - average) ** 2 for error in errors]),
        "coverage": 100.0 * len(true_cells & set(mapped)) / len(true_cells),
        "outliers": 100.0 * float((~inside).sum()) / len(points),
    }


def _cells(cloud: Cloud, side: float) -> list[tuple[int, ...]]:
    return [tuple(math.floor(value / side) for value in point) for point in cloud.tolist()]


def _nearest(points: Cloud, truth: Cloud) -> list[float]:
    """Return the distance of each point to the nearest true one [m]."""
    result: list[float] = []
    for start in range(0, len(points), _CHUNK):
        off = points[start : start + _CHUNK, None, :] - truth[None, :, :]
        result += np.sqrt((off * off).sum(axis=2).min(axis=1)).tolist()
    return result
