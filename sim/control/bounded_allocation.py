"""Thrust allocation under the limits of each thruster: a bounded least-squares problem."""

from numba import njit

from seamark.sim.numerics.arrays import Array

SWEEPS = 400  # E: accelerations are then within 0.01 of the optimum, for all vehicles


@njit(cache=True, error_model="numpy")
def allocate_within(
    hessian: Array, gradient: Array, lowest: Array, highest: Array, thrust: Array
) -> None:
    """Minimise f' H f / 2 - g' f over a box by cyclic coordinate descent.

    It converges for every positive definite H (Bertsekas 2016, Nonlinear Programming, 3.7).

    Parameters
    ----------
    hessian, gradient : (n, n) and (n,)
    lowest, highest : (n,) [N]
    thrust : (n,) [N]
        The start of the search, and its result.
    """
    for _ in range(SWEEPS):
        for i in range(thrust.size):
            rest = gradient[i]
            for j in range(thrust.size):
                if j != i:
                    rest -= hessian[i, j] * thrust[j]
            thrust[i] = min(max(rest / hessian[i, i], lowest[i]), highest[i])
