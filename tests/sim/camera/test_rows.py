"""The loops over rows: what they write is what their formula says, to the bit."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from seamark.sim.camera import rows
from seamark.sim.camera.seabed import STRIDE, TILE

_F = np.float32
ROWS = 131  # more than the maps that are kept at once
_TILE = np.random.default_rng(1).integers(0, 2**16, TILE * STRIDE, np.uint16)


@given(
    maps=st.lists(st.floats(-2.0, 2.0, width=32), min_size=9, max_size=9),
    row=st.integers(-32, 500),
    start=st.integers(-2, 40).map(lambda block: block * rows.NODE),
    shift=st.tuples(st.integers(-9000, 9000), st.integers(-9000, 9000)),
)
@settings(max_examples=60, deadline=None)
def test_the_vectorised_seabed_is_the_formula_in_single_precision(
    maps: list[float], row: int, start: int, shift: tuple[int, int]
) -> None:
    ground = np.array(maps).reshape(3, 3)
    ground[:2] *= 1e4  # many of these places lie beyond the reach
    written = np.empty(ROWS * 64, np.float32)
    rows.seabed_light(_TILE, ground, (row, start, 64), shift, written)
    expected = [_formula(ground, row + r, start, shift) for r in range(ROWS)]
    assert written.tobytes() == np.concatenate(expected).tobytes()


def _formula(ground: np.ndarray, row: int, start: int, shift: tuple[int, int]) -> np.ndarray:
    constant = (ground[:, 1] * row + ground[:, 2]).astype(_F)
    slope = ground[:, 0].astype(_F)
    a, b, w = (constant[k] + slope[k] * np.arange(start, start + 64).astype(_F) for k in range(3))
    z = _F(1.0) / np.maximum(w, _F(1e-3))
    u, v = (np.clip(value * z, _F(-4000.0), _F(4000.0)) + _F(rows.BIAS) for value in (a, b))
    iu, iv = u.astype(np.int32), v.astype(np.int32)
    fu, fv = u - iu.astype(_F), v - iv.astype(_F)
    at = (iv + shift[1]) % TILE * STRIDE + (iu + shift[0]) % TILE
    ul, ll = ((_TILE[at] >> k & 255).astype(_F) for k in (0, 8))
    ur, lr = ((_TILE[at + 1] >> k & 255).astype(_F) for k in (0, 8))
    top, low = ul + fu * (ur - ul), ll + fu * (lr - ll)
    return np.asarray(top + fv * (low - top))
