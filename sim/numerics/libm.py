"""Elementary functions that give the same bits on every x86-64 processor: sin to log.

The C library picks another variant (with fused multiply-add) on newer processors, so its last bit
moves with the machine and a trajectory with it. Here are range reduction and a Taylor series
instead, made of IEEE 754 `+ - * /` and `sqrt` alone; Numba without `fastmath` never contracts them.
Measured against `math`: sin, cos 2e-16 absolute; exp 4e-16, log, atan2, asin 5e-16 relative.
All arguments and results are float64 scalars, angles in rad.
"""

import math

from numba import njit

from seamark.sim.numerics.lanes import exponent, floor, mantissa, power_of_two, select

PI = 3.141592653589793  # [rad] nearest double
LARGEST_ANGLE = 1.0e6  # [rad] above it the three-part reduction is no longer exact

_TWO_OVER_PI = 0.6366197723675814
# pi/2 in three parts of 33 bits (fdlibm): k times a part is exact for k < 2**20.
_HALF_PI_HIGH = 1.57079632673412561417e00
_HALF_PI_MIDDLE = 6.07710050630396597660e-11
_HALF_PI_LOW = 2.02226624879595063154e-21

_LOG2_E = 1.4426950408889634
_LN2_HIGH = 6.93147180369123816490e-01  # 32 bits, so k * _LN2_HIGH is exact
_LN2_LOW = 1.90821492927058770002e-10
_LARGEST_EXPONENT = 709.782712893384  # exp() of more overflows
_SMALLEST_EXPONENT = -745.1332191019412  # exp() of less is zero

_SQRT_HALF = 0.7071067811865476
_LEAST_NORMAL = 2.2250738585072014e-308
_TWO_54 = 18014398509481984.0

# atan(i/8), i = 0..8: the argument is brought within 1/16 of one of these points.
_ATAN_OF_EIGHTHS = (
    0.0,
    0.12435499454676144,
    0.24497866312686414,
    0.3587706702705722,
    0.4636476090008061,
    0.5585993153435624,
    0.6435011087932844,
    0.7188299996216245,
    0.7853981633974483,
)


@njit(cache=True, error_model="numpy")
def _sin_core(r: float) -> float:
    """Return sin(r) for |r| <= pi/4 by its series to r**17 (next term 8e-20)."""
    z = r * r
    s = 1.0 / 355687428096000.0
    s = -1.0 / 1307674368000.0 + z * s
    s = 1.0 / 6227020800.0 + z * s
    s = -1.0 / 39916800.0 + z * s
    s = 1.0 / 362880.0 + z * s
    s = -1.0 / 5040.0 + z * s
    s = 1.0 / 120.0 + z * s
    s = -1.0 / 6.0 + z * s
    return r + r * (z * s)


@njit(cache=True, error_model="numpy")
def _cos_core(r: float) -> float:
    """Return cos(r) for |r| <= pi/4 by its series to r**18 (next term 3e-21)."""
    z = r * r
    c = -1.0 / 6402373705728000.0
    c = 1.0 / 20922789888000.0 + z * c
    c = -1.0 / 87178291200.0 + z * c
    c = 1.0 / 479001600.0 + z * c
    c = -1.0 / 3628800.0 + z * c
    c = 1.0 / 40320.0 + z * c
    c = -1.0 / 720.0 + z * c
    c = 1.0 / 24.0 + z * c
    return 1.0 - (0.5 * z - z * (z * c))


@njit(cache=True, error_model="numpy")
def sincos(x: float) -> tuple[float, float]:
    """Return (sin x, cos x) for |x| <= LARGEST_ANGLE, otherwise (nan, nan)."""
    valid = abs(x) <= LARGEST_ANGLE
    k = floor(x * _TWO_OVER_PI + 0.5)
    r = ((x - k * _HALF_PI_HIGH) - k * _HALF_PI_MIDDLE) - k * _HALF_PI_LOW
    s = _sin_core(r)
    c = _cos_core(r)
    quadrant = k - 4.0 * floor(0.25 * k)
    odd = (quadrant == 1.0) | (quadrant == 3.0)
    sine, cosine = select(odd, c, s), select(odd, s, c)
    sine = select(quadrant >= 2.0, -sine, sine)
    cosine = select((quadrant == 1.0) | (quadrant == 2.0), -cosine, cosine)
    return select(valid, sine, math.nan), select(valid, cosine, math.nan)


@njit(cache=True, error_model="numpy")
def sin(x: float) -> float:
    """Return the sine of x [rad], nan for |x| > LARGEST_ANGLE."""
    return sincos(x)[0]


@njit(cache=True, error_model="numpy")
def cos(x: float) -> float:
    """Return the cosine of x [rad], nan for |x| > LARGEST_ANGLE."""
    return sincos(x)[1]


@njit(cache=True, error_model="numpy")
def exp(x: float) -> float:
    """Return e**x; inf above 709.78, zero below -745.13, nan for nan."""
    usual = (x >= _SMALLEST_EXPONENT) & (x <= _LARGEST_EXPONENT)
    k = floor(select(usual, x, 0.0) * _LOG2_E + 0.5)
    r = (x - k * _LN2_HIGH) - k * _LN2_LOW
    s = 1.0 / 6227020800.0  # the series to r**13 (next term 4e-18)
    s = 1.0 / 479001600.0 + r * s
    s = 1.0 / 39916800.0 + r * s
    s = 1.0 / 3628800.0 + r * s
    s = 1.0 / 362880.0 + r * s
    s = 1.0 / 40320.0 + r * s
    s = 1.0 / 5040.0 + r * s
    s = 1.0 / 720.0 + r * s
    s = 1.0 / 120.0 + r * s
    s = 1.0 / 24.0 + r * s
    s = 1.0 / 6.0 + r * s
    s = 0.5 + r * s
    value = 1.0 + (r + (r * r) * s)
    half = floor(0.5 * k)  # in two steps: 2**1024 is not a double, but the product may be
    value = value * power_of_two(half) * power_of_two(k - half)
    value = select(x > _LARGEST_EXPONENT, math.inf, value)
    value = select(x < _SMALLEST_EXPONENT, 0.0, value)
    return select(x != x, x, value)  # noqa: PLR0124  # nan


@njit(cache=True, error_model="numpy")
def log(x: float) -> float:
    """Return the natural logarithm of x > 0; -inf for zero, nan for less and for nan."""
    small = x < _LEAST_NORMAL
    normal = select(small, x * _TWO_54, x)
    m = mantissa(normal)  # exact: x = m 2**k, 0.5 <= m < 1
    k = exponent(normal) - select(small, 54.0, 0.0)
    low = m < _SQRT_HALF
    m, k = select(low, 2.0 * m, m), select(low, k - 1.0, k)
    t = (m - 1.0) / (m + 1.0)  # log m = 2 atanh t, |t| <= 0.172
    z = t * t
    s = 1.0 / 21.0  # the series to t**21 (next term 1e-19)
    s = 1.0 / 19.0 + z * s
    s = 1.0 / 17.0 + z * s
    s = 1.0 / 15.0 + z * s
    s = 1.0 / 13.0 + z * s
    s = 1.0 / 11.0 + z * s
    s = 1.0 / 9.0 + z * s
    s = 1.0 / 7.0 + z * s
    s = 1.0 / 5.0 + z * s
    s = 1.0 / 3.0 + z * s
    value = k * _LN2_HIGH + (2.0 * (t + t * (z * s)) + k * _LN2_LOW)
    value = select(x > 0.0, select(x == math.inf, x, value), math.nan)
    return select(x == 0.0, -math.inf, value)


@njit(cache=True, error_model="numpy")
def _atan_unit(t: float) -> float:
    """Return atan(t) for 0 <= t <= 1."""
    i = int(t * 8.0 + 0.5)
    c = i * 0.125
    r = (t - c) / (1.0 + t * c)
    z = r * r
    s = 1.0 / 13.0  # the series to r**13 with |r| <= 1/16 (next term 6e-20)
    s = -1.0 / 11.0 + z * s
    s = 1.0 / 9.0 + z * s
    s = -1.0 / 7.0 + z * s
    s = 1.0 / 5.0 + z * s
    s = -1.0 / 3.0 + z * s
    return _ATAN_OF_EIGHTHS[i] + (r + r * (z * s))


@njit(cache=True, error_model="numpy")
def atan2(y: float, x: float) -> float:
    """Return the angle of (x, y) in [-pi, pi]; zero for the origin, nan for nan.

    The sign of a zero does not matter: atan2(-0.0, -1.0) is pi.
    """
    if math.isnan(x) or math.isnan(y):
        return math.nan
    ax = abs(x)
    ay = abs(y)
    if ax == 0.0 and ay == 0.0:
        return 0.0
    angle = 0.5 * PI - _atan_unit(ax / ay) if ay > ax else _atan_unit(ay / ax)
    if x < 0.0:
        angle = PI - angle
    return -angle if y < 0.0 else angle


@njit(cache=True, error_model="numpy")
def asin(x: float) -> float:
    """Return the arc sine of x in [-pi/2, pi/2], nan for |x| > 1."""
    if not abs(x) <= 1.0:
        return math.nan
    return atan2(x, math.sqrt((1.0 - x) * (1.0 + x)))


def polar(distance: float, share: float) -> tuple[float, float]:
    """Return a point at a distance, in a direction that is a share of the full circle."""
    sine, cosine = sincos(2.0 * PI * share)
    return distance * cosine, distance * sine
