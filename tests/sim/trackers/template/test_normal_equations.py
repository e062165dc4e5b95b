"""The equations of one step of the template tracker."""

import numpy as np

from seamark.sim.trackers.template.level_buffers import (
    ALONG,
    DOWN,
    PATCH,
    TEMPLATE,
    allocate_levels,
    pyramid_level,
)
from seamark.sim.trackers.template.normal_equations import normal_equations

COLUMNS, ROWS = 35, 11  # the third vector of a row is not full
HALF, GAIN, BIAS = 0.4, 1.1, -7.0


def test_normal_equations_are_those_of_all_pixels_and_of_none_beyond_the_last_column() -> None:
    level = pyramid_level(allocate_levels(COLUMNS, ROWS, 1), 0)
    level.planes[:] = np.random.default_rng(5).normal(60.0, 30.0, level.planes.shape)
    planes = [level.planes[k] for k in (PATCH, TEMPLATE, ALONG, DOWN)]
    a, g = np.zeros((8, 8)), np.zeros(8)

    normal_equations(tuple(planes), (level.columns, level.ys), (HALF, GAIN, BIAS), a, g)

    patch, template, along, down = (plane.astype(np.float64) for plane in planes)
    inner = (slice(ROWS), slice(COLUMNS))
    gx = HALF * (patch[1:-1, 2:] - patch[1:-1, :-2])[inner] + along[inner]
    gy = HALF * (patch[2:, 1:-1] - patch[:-2, 1:-1])[inner] + down[inner]
    error = (template[inner] - BIAS - GAIN * patch[1:-1, 1:][inner]).ravel()
    x, y = level.columns[1, :COLUMNS].astype(np.float64), level.ys.astype(np.float64)[:, None]
    t = gx * x + gy * y
    columns = [gx * x, gx * y, gy * x, gy * y, -x * t, -y * t, gx, gy]
    jacobian = np.stack([column.ravel() for column in columns], axis=1)
    np.testing.assert_allclose(a, jacobian.T @ jacobian, rtol=1e-4, atol=1e-5 * a.max())
    np.testing.assert_allclose(g, jacobian.T @ error, rtol=1e-4, atol=1e-5 * abs(g).max())
