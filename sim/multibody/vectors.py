"""Vectors of three numbers, or of three lanes, for compiled code."""

from numba import njit

from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.lanes import like, select, sqrt

Vector = tuple[float, float, float]
_REFERENCE = (0.36, 0.48, 0.8)  # no normal of a plane, wall or box is likely to be parallel to it
_OTHER_REFERENCE = (0.48, -0.6, 0.64)
_PARALLEL = 0.01  # squared sine below which the other one is taken


@njit(cache=True, error_model="numpy")
def cross(a: Vector, b: Vector) -> Vector:
    """Return a x b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@njit(cache=True, error_model="numpy")
def dot(a: Vector, b: Vector) -> float:
    """Return a · b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True, error_model="numpy")
def plus(a: Vector, b: Vector) -> Vector:
    """Return a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@njit(cache=True, error_model="numpy")
def minus(a: Vector, b: Vector) -> Vector:
    """Return a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@njit(cache=True, error_model="numpy")
def times(a: Vector, factor: float) -> Vector:
    """Return a times a number."""
    return a[0] * factor, a[1] * factor, a[2] * factor


@njit(cache=True, error_model="numpy")
def choose(condition: bool, a: Vector, b: Vector) -> Vector:
    """Return a where the condition holds and b elsewhere."""
    return (
        select(condition, a[0], b[0]),
        select(condition, a[1], b[1]),
        select(condition, a[2], b[2]),
    )


@njit(cache=True, error_model="numpy")
def larger(a: float, b: float) -> float:
    """Return the larger of two numbers; b if one is not a number."""
    return select(a > b, a, b)


@njit(cache=True, error_model="numpy")
def smaller(a: float, b: float) -> float:
    """Return the smaller of two numbers; b if one is not a number."""
    return select(a < b, a, b)


@njit(cache=True, error_model="numpy")
def clamped(x: float, low: float, high: float) -> float:
    """Return the number between two limits that is nearest to x."""
    return smaller(larger(x, low), high)


@njit(cache=True, error_model="numpy")
def unit_or(a: Vector, otherwise: Vector, least: float) -> Vector:
    """Return a with length 1, or another vector if its length is at most `least`."""
    length = sqrt(dot(a, a))
    long = length > least
    return choose(long, times(a, 1.0 / select(long, length, 1.0)), otherwise)


@njit(cache=True, error_model="numpy")
def across(normal: Vector) -> Vector:
    """Return a unit vector across a unit vector: a fixed choice.

    Every choice jumps in some direction (the hairy ball). This one does so on a small circle
    around an unlikely direction, since friction of the last step is kept in these axes.
    """
    zero = like(normal[0], 0.0)
    a = cross((zero + _REFERENCE[0], zero + _REFERENCE[1], zero + _REFERENCE[2]), normal)
    b = cross(
        (zero + _OTHER_REFERENCE[0], zero + _OTHER_REFERENCE[1], zero + _OTHER_REFERENCE[2]),
        normal,
    )
    chosen = choose(dot(a, a) > _PARALLEL, a, b)
    return times(chosen, 1.0 / sqrt(dot(chosen, chosen)))


@njit(cache=True, error_model="numpy", inline="always")
def rotate(m: Array, i: int, v: Vector) -> Vector:
    """Return m[i] v of matrices (k, 3, 3)."""
    x, y, z = v
    return (
        m[i, 0, 0] * x + m[i, 0, 1] * y + m[i, 0, 2] * z,
        m[i, 1, 0] * x + m[i, 1, 1] * y + m[i, 1, 2] * z,
        m[i, 2, 0] * x + m[i, 2, 1] * y + m[i, 2, 2] * z,
    )


@njit(cache=True, error_model="numpy", inline="always")
def rotate_back(m: Array, i: int, v: Vector) -> Vector:
    """Return m[i]^T v of matrices (k, 3, 3)."""
    x, y, z = v
    return (
        m[i, 0, 0] * x + m[i, 1, 0] * y + m[i, 2, 0] * z,
        m[i, 0, 1] * x + m[i, 1, 1] * y + m[i, 2, 1] * z,
        m[i, 0, 2] * x + m[i, 1, 2] * y + m[i, 2, 2] * z,
    )


@njit(cache=True, error_model="numpy", inline="always")
def six_times(m: Array, i: int, linear: Vector, angular: Vector) -> tuple[Vector, Vector]:
    """Return m[i] times a twist, of matrices (k, 6, 6)."""
    return (
        (
            _row_times(m, i, 0, linear, angular),
            _row_times(m, i, 1, linear, angular),
            _row_times(m, i, 2, linear, angular),
        ),
        (
            _row_times(m, i, 3, linear, angular),
            _row_times(m, i, 4, linear, angular),
            _row_times(m, i, 5, linear, angular),
        ),
    )


@njit(cache=True, error_model="numpy", inline="always")
def _row_times(m: Array, i: int, row: int, linear: Vector, angular: Vector) -> float:
    value = like(linear[0], 0.0)  # a sum that begins with zero is never -0.0
    for j in range(3):
        value += m[i, row, j] * linear[j]
    for j in range(3):
        value += m[i, row, 3 + j] * angular[j]
    return value


@njit(cache=True, error_model="numpy", inline="always")
def column(m: Array, i: int, j: int) -> Vector:
    """Return column j of m[i], of matrices (k, 3, 3)."""
    return m[i, 0, j], m[i, 1, j], m[i, 2, j]


@njit(cache=True, error_model="numpy", inline="always")
def three(m: Array, i: int, first: int) -> Vector:
    """Return three numbers of a row."""
    return m[i, first], m[i, first + 1], m[i, first + 2]


@njit(cache=True, error_model="numpy", inline="always")
def put(m: Array, i: int, first: int, v: Vector) -> None:
    """Write three numbers of a row."""
    m[i, first], m[i, first + 1], m[i, first + 2] = v[0], v[1], v[2]
