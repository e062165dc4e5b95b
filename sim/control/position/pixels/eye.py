"""The eye: a small convolutional network that says where in an image the target is.

A cell is a square of 32 x 32 pixels of the image. Each of 15 x 20 cells has a score, and how far
from its middle the centre of the target is. No target in view has a score of zero.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.detectors.network.convolution import Layer, convolve, layer_of, plane

HEIGHT_PX, WIDTH_PX = 480, 640  # of an image
POOLED = 8  # pixels, whose mean is one of those that the network gets
HEIGHT, WIDTH = HEIGHT_PX // POOLED, WIDTH_PX // POOLED
CELL_PX = 32
ROWS, COLUMNS = HEIGHT_PX // CELL_PX, WIDTH_PX // CELL_PX
LEAST_CONTRAST = 1.0  # grey levels; noise alone has less
OUTPUTS = 3  # of a cell: score, and offsets to the right and down in cells


class Convolution(NamedTuple):
    """Channels of a layer of 3 x 3 pixels, and how far its window moves from output to output."""

    inputs: int
    outputs: int
    stride: int = 1


LAYERS = (  # each gets the output of the one before it; all but the last are rectified
    Convolution(1, 16, stride=2),
    Convolution(16, 32, stride=2),
    Convolution(32, 32),
    Convolution(32, 32),
    Convolution(32, OUTPUTS),
)


class Eye:
    """Finds the target in one image."""

    def __init__(self, weights: Mapping[str, NDArray[Any]]) -> None:
        """Take weights0 (O, C, 3, 3), biases0 (O,), and so on."""
        self._seen = plane(HEIGHT, WIDTH, 1)
        self._layers: list[Layer] = []
        height, width = HEIGHT, WIDTH
        for number, (_, _, stride) in enumerate(LAYERS):
            height, width = height // stride, width // stride
            self._layers.append(
                layer_of(
                    weights[f"weights{number}"],
                    weights[f"biases{number}"],
                    (height, width),
                    stride=stride,
                    rectified=number < len(LAYERS) - 1,
                )
            )

    def find(self, image: NDArray[np.uint8]) -> tuple[float, float] | None:
        """Return the target's centre minus the image's [px], right and down; None without one."""
        output = self.output(image)
        best = int(output[0].argmax())
        score, right, down = output.reshape(OUTPUTS, -1)[:, best].tolist()
        if score <= 0.0:
            return None
        row, column = divmod(best, COLUMNS)
        return (
            CELL_PX * (column + 0.5 + right - 0.5 * COLUMNS),
            CELL_PX * (row + 0.5 + down - 0.5 * ROWS),
        )

    def output(self, image: NDArray[np.uint8]) -> NDArray[np.float32]:
        """Return the output (OUTPUTS, ROWS, COLUMNS) for an image (480, 640)."""
        normalise(image, self._seen)
        last = self._seen
        for layer in self._layers:
            convolve(last, layer)
            last = layer.output
        cells = last.reshape(ROWS + 2, COLUMNS + 2, -1)[1:-1, 1:-1, :OUTPUTS]
        return np.ascontiguousarray(cells.transpose(2, 0, 1))


@njit(cache=True, nogil=True, error_model="numpy")
def normalise(image: NDArray[np.uint8], seen: NDArray[np.float32]) -> None:
    """Write means of squares of pixels, in units of their contrast, into an image with its frame.

    All sums are of integers, so their order does not matter.
    """
    sums = np.zeros((HEIGHT, WIDTH), np.int64)
    for row in range(HEIGHT_PX):
        for column in range(WIDTH):
            total = 0
            for pixel in range(POOLED * column, POOLED * column + POOLED):
                total += image[row, pixel]
            sums[row // POOLED, column] += total
    count, total, squares = HEIGHT * WIDTH, 0, 0
    for row in range(HEIGHT):
        for column in range(WIDTH):
            total += sums[row, column]
            squares += sums[row, column] * sums[row, column]
    mean = total / count
    least = LEAST_CONTRAST * POOLED * POOLED
    variance = (squares * count - total * total) / (count * count)
    contrast = np.sqrt(max(variance, least * least))
    for row in range(HEIGHT):
        for column in range(WIDTH):
            value = (sums[row, column] - mean) / contrast
            seen[(row + 1) * (WIDTH + 2) + column + 1, 0] = np.float32(value)
