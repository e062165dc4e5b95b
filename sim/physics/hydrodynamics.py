"""Hydrodynamic and hydrostatic forces on a rigid body, as compiled functions on arrays.

Body frame: x forward, y starboard, z down (Fossen 2021, ch. 2). SI units, angles in rad. Wrenches
are (6,) [N, N m] about the body's origin. Nothing here uses BLAS, libm or fused operations. The
functions are inlined by Numba: calls would count references and take twice as long.
"""

from numba import njit

from seamark.sim.numerics.arrays import Array


@njit(cache=True, error_model="numpy", inline="always")
def write_rotation(w: float, x: float, y: float, z: float, out: Array) -> None:
    """Write the rotation matrix (3, 3), body to world, of a unit quaternion to `out`."""
    out[0, 0] = 1.0 - 2.0 * (y * y + z * z)
    out[0, 1] = 2.0 * (x * y - w * z)
    out[0, 2] = 2.0 * (x * z + w * y)
    out[1, 0] = 2.0 * (x * y + w * z)
    out[1, 1] = 1.0 - 2.0 * (x * x + z * z)
    out[1, 2] = 2.0 * (y * z - w * x)
    out[2, 0] = 2.0 * (x * z - w * y)
    out[2, 1] = 2.0 * (y * z + w * x)
    out[2, 2] = 1.0 - 2.0 * (x * x + y * y)


@njit(cache=True, error_model="numpy", inline="always")
def add_coriolis(mass: Array, velocity: Array, momentum: Array, wrench: Array) -> None:
    """Subtract C(v) v of a body with mass matrix (6, 6) from the wrench (6,).

    With the momentum (p, h) = M v this is (ω x p, ω x h + v x p), which does no work.
    `momentum`, (6,), is a buffer for the intermediate result.
    """
    for i in range(6):
        value = 0.0
        for j in range(6):
            value += mass[i, j] * velocity[j]
        momentum[i] = value
    u, v, w = velocity[0], velocity[1], velocity[2]
    p, q, r = velocity[3], velocity[4], velocity[5]
    x, y, z = momentum[0], momentum[1], momentum[2]
    k, m, n = momentum[3], momentum[4], momentum[5]
    wrench[0] -= q * z - r * y
    wrench[1] -= r * x - p * z
    wrench[2] -= p * y - q * x
    wrench[3] -= q * n - r * m + v * z - w * y
    wrench[4] -= r * k - p * n + w * x - u * z
    wrench[5] -= p * m - q * k + u * y - v * x


@njit(cache=True, error_model="numpy", inline="always")
def add_drag(linear: Array, quadratic: Array, velocity: Array, wrench: Array) -> None:
    """Add the drag at a velocity relative to the water, all (6,), without coupling of the axes.

    It only dissipates energy: drag @ velocity <= 0.
    """
    for i in range(6):
        wrench[i] -= (linear[i] + quadratic[i] * abs(velocity[i])) * velocity[i]


@njit(cache=True, error_model="numpy", inline="always")
def add_restoring(
    net_weight: float, moment: Array, down: tuple[float, float, float], wrench: Array
) -> None:
    """Add weight and buoyancy.

    Parameters
    ----------
    net_weight : float [N]
        Weight minus buoyancy.
    moment : (3,) [N m]
        Weight times centre of gravity minus buoyancy times centre of buoyancy.
    down : three floats
        Apparent downward direction in the body frame; a unit vector in steady flow. Accelerating
        water tilts it, since pressure gradient and inertia together act like gravity.
    """
    x, y, z = down
    wrench[0] += net_weight * x
    wrench[1] += net_weight * y
    wrench[2] += net_weight * z
    wrench[3] += moment[1] * z - moment[2] * y
    wrench[4] += moment[2] * x - moment[0] * z
    wrench[5] += moment[0] * y - moment[1] * x
