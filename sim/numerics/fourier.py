"""The discrete Fourier transform with the same bits on every processor: radix 2 (Cooley, Tukey).

Libraries choose their code, and the sines of their tables, by the processor. Sizes are powers of
two.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.libm import PI, sincos

Complex = NDArray[np.complex128]


def roots(size: int) -> Complex:
    """Return exp(-2 pi i k / size) for k below half of the size, which is a power of two."""
    if size < 1 or size & (size - 1):
        raise ValueError(f"{size} is no power of two")
    angles = [2.0 * PI * k / size for k in range(max(size // 2, 1))]
    return np.array([complex(cosine, -sine) for sine, cosine in map(sincos, angles)])


@njit(cache=True, error_model="numpy")
def transform(data: Complex, row_roots: Complex, column_roots: Complex) -> None:
    """Transform an image, (H, W), in place; the roots are those of W and of H."""
    for row in range(data.shape[0]):
        _transform_line(data[row], row_roots)
    line = np.empty(data.shape[0], np.complex128)
    for column in range(data.shape[1]):
        line[:] = data[:, column]
        _transform_line(line, column_roots)
        data[:, column] = line


@njit(cache=True, error_model="numpy")
def inverse_real(data: Complex, row_roots: Complex, column_roots: Complex, out: Array) -> None:
    """Write the real part of the inverse transform of `data`, (H, W), which is overwritten."""
    for row in range(data.shape[0]):
        for column in range(data.shape[1]):
            data[row, column] = data[row, column].conjugate()
    transform(data, row_roots, column_roots)
    for row in range(data.shape[0]):
        for column in range(data.shape[1]):
            out[row, column] = data[row, column].real / data.size


@njit(cache=True, error_model="numpy")
def _transform_line(line: Complex, unit_roots: Complex) -> None:
    """Transform one line in place, by butterflies after the order of reversed bits."""
    size = line.size
    at = 0
    for k in range(1, size):
        bit = size >> 1
        while at & bit:
            at ^= bit
            bit >>= 1
        at |= bit
        if k < at:
            line[k], line[at] = line[at], line[k]
    half = 1
    while half < size:
        stride = size // (2 * half)
        for start in range(0, size, 2 * half):
            for k in range(half):
                turned = line[start + half + k] * unit_roots[k * stride]
                line[start + half + k] = line[start + k] - turned
                line[start + k] += turned
        half *= 2
