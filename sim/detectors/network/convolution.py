"""Convolutions of a small network, computed in a fixed order: every processor gives the same bits.

An image of C channels is a matrix of one row for each pixel, with a frame of zeros one pixel wide:
((H + 2) (W + 2), C). A layer of O outputs has weights (9 C, O): rows in the order of the pixels of
its 3 x 3 window, row by row, and of the channels of each. O is a multiple of 16.
"""

from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.numerics.simd import WIDTH, f32x16, fma, load, maximum, store

Matrix = NDArray[np.float32]
AT_ONCE = 5  # pixels: their sums and the weights fit into sixteen registers of 256 bit, twice each


class Layer(NamedTuple):
    """One layer and where its output goes."""

    weights: Matrix  # (9 C, O)
    biases: Matrix  # (1, O)
    width: int  # [px] of the output, a multiple of AT_ONCE
    stride: int
    rectified: bool
    output: Matrix  # ((H + 2) (W + 2), O)


def plane(height: int, width: int, channels: int) -> Matrix:
    """Return an image of zeros with its frame."""
    return np.zeros(((height + 2) * (width + 2), channels), np.float32)


def layer_of(
    weights: NDArray[Any],
    biases: NDArray[Any],
    size: tuple[int, int],
    *,
    stride: int,
    rectified: bool,
) -> Layer:
    """Return a layer of weights (O, C, 3, 3) and biases (O,); more outputs fill up a vector."""
    outputs, inputs, _, _ = weights.shape
    padded = -(-outputs // WIDTH) * WIDTH
    in_rows, in_row = np.zeros((9 * inputs, padded), np.float32), np.zeros((1, padded), np.float32)
    in_rows[:, :outputs] = weights.transpose(2, 3, 1, 0).reshape(9 * inputs, outputs)
    in_row[0, :outputs] = biases
    return Layer(in_rows, in_row, size[1], stride, rectified, plane(*size, padded))


@njit(cache=True, nogil=True, error_model="numpy")
def convolve(image: Matrix, layer: Layer) -> None:
    """Compute the output of a layer.

    Each sum begins with the bias and goes through the window in the order of the weights; every
    product is added with one rounding.
    """
    pitch, step = layer.width + 2, layer.stride
    width_before = layer.width * step
    height, channels = layer.output.shape[0] // pitch - 2, image.shape[1]
    floor = f32x16(np.float32(0.0) if layer.rectified else np.float32(-np.inf))
    for row in range(height):
        for column in range(0, layer.width, AT_ONCE):
            first = row * step * (width_before + 2) + column * step
            into = (row + 1) * pitch + column + 1
            for block in range(0, layer.output.shape[1], WIDTH):
                a = b = c = d = e = load(layer.biases, 0, block)
                for tap in range(9):
                    at = first + tap // 3 * (width_before + 2) + tap % 3
                    for channel in range(channels):
                        weight = load(layer.weights, tap * channels + channel, block)
                        a = fma(f32x16(image[at, channel]), weight, a)
                        b = fma(f32x16(image[at + step, channel]), weight, b)
                        c = fma(f32x16(image[at + 2 * step, channel]), weight, c)
                        d = fma(f32x16(image[at + 3 * step, channel]), weight, d)
                        e = fma(f32x16(image[at + 4 * step, channel]), weight, e)
                store(layer.output, into, block, maximum(a, floor))
                store(layer.output, into + 1, block, maximum(b, floor))
                store(layer.output, into + 2, block, maximum(c, floor))
                store(layer.output, into + 3, block, maximum(d, floor))
                store(layer.output, into + 4, block, maximum(e, floor))


@njit(cache=True, nogil=True, error_model="numpy")
def add_doubled(small: Matrix, width: int, large: Matrix) -> None:
    """Add an image to another of twice its size, each pixel to four; `width` is that of `large`."""
    pitch, small_pitch = width + 2, width // 2 + 2
    for row in range(large.shape[0] // pitch - 2):
        for column in range(width):
            into = (row + 1) * pitch + column + 1
            at = (row // 2 + 1) * small_pitch + column // 2 + 1
            for block in range(0, large.shape[1], WIDTH):
                store(large, into, block, load(large, into, block) + load(small, at, block))
