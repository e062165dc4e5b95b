"""The equations of one step of the template tracker."""

import numpy as np

from seamark.sim.trackers.template.normal_equations import normal_equations

COLUMNS, ROWS = 35, 11  # the third vector of a row is not full
WIDTH = 64  # of a plane: whole vectors, and one more
HALF, GAIN, BIAS = 0.4, 1.1, -7.0


def test_normal_equations_are_those_of_all_pixels_and_of_none_beyond_the_last_column() -> None:
    random, numbers = np.random.default_rng(5), np.arange(WIDTH)
    patch = random.normal(60.0, 30.0, (ROWS + 2, WIDTH)).astype(np.float32)
    template, along, down = random.normal(60.0, 30.0, (3, ROWS, WIDTH)).astype(np.float32)
    xs, ys = numbers / 17.0 - 1.0, (np.arange(ROWS) / 17.0 - 0.3).astype(np.float32)
    columns = np.array([numbers, xs, numbers < COLUMNS], dtype=np.float32)
    a, g = np.zeros((8, 8)), np.zeros(8)

    normal_equations((patch, template, along, down), (columns, ys), (HALF, GAIN, BIAS), a, g)

    inner = (slice(ROWS), slice(COLUMNS))
    gx = HALF * (patch[1:-1, 2:] - patch[1:-1, :-2])[inner] + along[inner]
    gy = HALF * (patch[2:, 1:-1] - patch[:-2, 1:-1])[inner] + down[inner]
    error = (template[inner] - BIAS - GAIN * patch[1:-1, 1:][inner]).ravel()
    x, y = xs[:COLUMNS], ys[:, None]
    t = gx * x + gy * y
    parts = [gx * x, gx * y, gy * x, gy * y, -x * t, -y * t, gx, gy]
    jacobian = np.stack([part.ravel() for part in parts], axis=1).astype(np.float64)
    np.testing.assert_allclose(a, jacobian.T @ jacobian, rtol=1e-4, atol=1e-5 * a.max())
    np.testing.assert_allclose(g, jacobian.T @ error, rtol=1e-4, atol=1e-5 * abs(g).max())
