"""Elementary functions of arrays that give the same bits on every processor, without Numba.

NumPy's own vary in the last bit with the processor's instructions. For what pages load, which must
not load compiled code; `libm` has those for scalars in compiled code.
"""

import numpy as np

from seamark.sim.numerics.arrays import Array

_TERMS = 8  # of a Taylor series: the next one of pi/4 is below 1e-16
_HALVINGS = 2  # angles up to a half turn become those up to pi/4


def sincos(angle: Array) -> tuple[Array, Array]:
    """Return sine and cosine of angles within plus or minus pi, to 1e-14.

    Parameters
    ----------
    angle : (k,) [rad]
    """
    r = angle / 2.0**_HALVINGS
    square = r * r
    sine, cosine = np.ones_like(r), np.ones_like(r)
    for n in range(_TERMS, 0, -1):
        sine = 1.0 - square / ((2 * n) * (2 * n + 1)) * sine
        cosine = 1.0 - square / ((2 * n - 1) * (2 * n)) * cosine
    sine = r * sine
    for _ in range(_HALVINGS):
        sine, cosine = 2.0 * sine * cosine, 1.0 - 2.0 * sine * sine
    return sine, cosine
