"""The equations of one step of the template tracker."""

import numpy as np
import pytest

from seamark.sim.trackers.template.normal_equations import normal_equations

COLUMNS, ROWS = 35, 11  # the third vector of a row is not full
WIDTH = 64  # of a plane: whole vectors, and one more
HALF, OWN, GAIN, BIAS = 0.4, 0.3, 1.1, -7.0


@pytest.mark.parametrize("rim", [0, 1])
def test_normal_equations_are_those_of_all_pixels_and_of_none_beyond_the_last_column(
    rim: int,
) -> None:
    random, numbers = np.random.default_rng(5), np.arange(WIDTH)
    planes = random.normal(60.0, 30.0, (3, ROWS + 2, WIDTH)).astype(np.float32)
    patch, template, goal = planes
    xs, ys = numbers / 17.0 - 1.0, (np.arange(ROWS) / 17.0 - 0.3).astype(np.float32)
    columns = np.array([numbers, xs, numbers < COLUMNS], dtype=np.float32)
    a, g = np.zeros((8, 8)), np.zeros(8)

    model = (HALF, OWN, GAIN, BIAS)
    normal_equations((patch, template, goal), rim, (columns, ys), COLUMNS, model, a, g)

    inner = (slice(ROWS), slice(COLUMNS))
    both = HALF * patch + OWN * template
    gx = (both[1:-1, 2:] - both[1:-1, :-2])[inner]
    gy = (both[2:, 1:-1] - both[:-2, 1:-1])[inner]
    error = (goal[rim:, rim:][inner] - BIAS - GAIN * patch[1:-1, 1:][inner]).ravel()
    x, y = xs[:COLUMNS], ys[:, None]
    t = gx * x + gy * y
    parts = [gx * x, gx * y, gy * x, gy * y, -x * t, -y * t, gx, gy]
    jacobian = np.stack([part.ravel() for part in parts], axis=1).astype(np.float64)
    np.testing.assert_allclose(a, jacobian.T @ jacobian, rtol=1e-4, atol=1e-5 * a.max())
    np.testing.assert_allclose(g, jacobian.T @ error, rtol=1e-4, atol=1e-5 * abs(g).max())
