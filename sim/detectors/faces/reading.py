"""Reads the letters on a face: how much likelier the right ones are than any others."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.detectors.faces.fitting import (
    NOISE,
    Levels,
    Map,
    Plane,
    letter_field,
    looked_up,
    on_face,
    region,
)
from seamark.sim.detectors.faces.picture import ALPHABET, LETTERS, Texels
from seamark.sim.numerics.libm import exp, log

_BLUNDER = 0.04  # E: how often something hides a letter, so that the pixels there mean nothing
_WRONG = 0.05  # E: of the gain: what is off even in the clearest water


@njit(cache=True, nogil=True, error_model="numpy")
def misfits(
    image: Plane, at: Map, pictures: Texels, have: Levels
) -> tuple[NDArray[np.float64], float]:
    """Return how far each field is off each letter, (LETTERS, ALPHABET) [grey²], and its pixels.

    The former are sums of squares, the latter are those of all fields.
    """
    here = region(image, at)
    out, pixels = np.zeros((LETTERS, ALPHABET)), 0.0
    for r in range(here.top, here.bottom + 1):
        for c in range(here.left, here.right + 1):
            x, y = on_face(here, at, c, r)
            field = letter_field(x, y)
            if field < 0:
                continue
            pixels += 1.0
            for letter in range(ALPHABET):
                value = looked_up(pictures[letter], x, y)[0]
                off = image[r, c] - have.ink - have.gain * value
                out[field, letter] += off * off
    return out, pixels


@njit(cache=True, nogil=True, error_model="numpy")
def likeliest(squares: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return which letter each field has, (LETTERS,)."""
    out = np.empty(LETTERS, np.int64)
    for field in range(LETTERS):
        out[field] = squares[field].argmin()
    return out


@njit(cache=True, nogil=True, error_model="numpy")
def evidence(
    squares: NDArray[np.float64], pixels: float, have: Levels, right: NDArray[np.int64]
) -> float:
    """Return the logarithm of how many times likelier the right letters are than others.

    At each place any other letter is as likely as any, and what differs from the likeliest letters
    is noise.
    """
    off = 0.0
    for field in range(LETTERS):
        off += squares[field].min()
    variance = max(off / max(pixels, 1.0), NOISE**2, (_WRONG * have.gain) ** 2)
    total = 0.0
    for field in range(LETTERS):
        lowest, mine, others = squares[field].min(), 0.0, 0.0
        for letter in range(ALPHABET):
            likely = exp(-0.5 * (squares[field, letter] - lowest) / variance)
            if letter == right[field]:
                mine = likely
            else:
                others += likely / (ALPHABET - 1)
        hidden = 0.5 * _BLUNDER * (mine + others)
        total += log((mine + hidden) / (others + hidden))
    return total
