"""What the network of the learned entry gets of an image, and what its output means.

An archive with a learned detector has this text, too: `examples/detector/train.py` packs it. All
sums are of whole numbers or have one order, so that every processor gives the same bits.
"""

from collections.abc import Iterator
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from seamark.sim.numerics.libm import exp

Array = NDArray[np.float64]
LABELS = ("box", "amphora", "pipe", "panel", "connector", "anode", "aruco", "apriltag")
STRIDE = 8  # [px] from one cell of the output to the next
CELLS = (30, 40)  # rows and columns of the output
SIZE_PX = 32.0  # a predicted logarithm of 0 is this side of the upright box
SHAPE = 6  # numbers of a cell beside the scores of the classes
OUTPUTS = len(LABELS) + SHAPE
VIEWS = 6  # of an image
AROUND, COARSE, FINER = 31, 7, 3  # [2 px] sides of the means
DIMMEST = 1e-3  # [grey] of contrast; a flat image has none
LEAST_SCORE = -4.0  # logit; below it, answers cost more precision than they bring recall
ANSWERS = 2  # most answers of a class in an image


def views(image: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Return what the network sees, (VIEWS, H / 2, W / 2), of a grey image (H, W).

    They are the four pixels of each square of 2 x 2 and two means around it, each relative to the
    mean of a wide window, in units of its contrast: turbid water leaves little contrast at a pixel,
    but more of it than of the noise in a mean.
    """
    grey = image.astype(np.int32)
    squares = [grey[row::2, column::2] for row in (0, 1) for column in (0, 1)]
    half = squares[0] + squares[1] + squares[2] + squares[3]
    around = 0.25 * _mean(half, AROUND)
    fine, coarse = (0.25 * _mean(half, side) - around for side in (FINER, COARSE))
    parts = (np.stack(squares) - around, fine[None], coarse[None])
    return np.concatenate([_in_contrast(part) for part in parts])


def _in_contrast(part: Array) -> NDArray[np.float32]:
    """Return values in units of the root of their mean square; the sum has but one order."""
    squares = np.add.accumulate((part * part).ravel())
    values: NDArray[np.float64] = part / (np.sqrt(squares[-1] / part.size) + DIMMEST)
    return values.astype(np.float32)


def _mean(values: NDArray[np.int32], side: int) -> Array:
    """Return the mean over the window around each value, of what is inside of the image."""
    return _sums(values, side) / _counts(values.shape, side)


def _sums(values: NDArray[np.int32], side: int) -> NDArray[np.int32]:
    for _ in (0, 1):
        rows, columns = values.shape
        reach = side // 2
        sums = np.zeros((rows + side, columns), np.int32)
        sums[reach + 1 : reach + 1 + rows] = values
        np.cumsum(sums, axis=0, out=sums)
        values = (sums[side:] - sums[:-side]).T
    return values


@lru_cache(maxsize=8)
def _counts(shape: tuple[int, int], side: int) -> NDArray[np.int32]:
    return _sums(np.ones(shape, np.int32), side)


def answers(output: NDArray[np.float32]) -> list[tuple[str, Array, float]]:
    """Return label, corners (4, 2) [px] and confidence of what the network found.

    Parameters
    ----------
    output : (OUTPUTS, 30, 40)
        For each cell a score of each class (a logit), where the centre is from that of the cell
        (two numbers, in cells), the logarithms of width and height of the upright box (in SIZE_PX),
        and where along the upper and the right side of it the corners are (two logits).
    """
    found = []
    for number, label in enumerate(LABELS):
        scores = output[number]
        for row, column in _peaks(scores):
            shape = output[len(LABELS) :, row, column].tolist()
            confidence = _share(float(scores[row, column]))
            found.append((label, corners_of(row, column, shape), confidence))
    return sorted(found, key=lambda one: -one[2])


def _peaks(scores: NDArray[np.float32]) -> Iterator[tuple[int, int]]:
    """Yield the highest cells of which no neighbour is higher."""
    rows, columns = scores.shape
    framed = np.full((rows + 2, columns + 2), -np.inf, np.float32)
    framed[1:-1, 1:-1] = scores
    around = np.max(
        [framed[j : j + rows, i : i + columns] for j in range(3) for i in range(3)], axis=0
    )
    at = np.flatnonzero((scores >= around) & (scores > LEAST_SCORE))
    highest = at[np.argsort(-scores.ravel()[at], kind="stable")[:ANSWERS]]
    yield from (divmod(one, columns) for one in highest.tolist())


def corners_of(row: int, column: int, shape: list[float]) -> Array:
    """Return the corners (4, 2) [px], clockwise from the upper one, of a cell's six numbers."""
    right, down, log_width, log_height, *logits = shape
    u, v = ((at + 0.5) * STRIDE - 0.5 for at in (column + right, row + down))
    width, height = (SIZE_PX * exp(min(one, 3.0)) for one in (log_width, log_height))
    across, along = (_share(one) for one in logits)
    left, upper = u - 0.5 * width, v - 0.5 * height
    return np.array(
        [
            [left + across * width, upper],
            [left + width, upper + along * height],
            [left + width - across * width, upper + height],
            [left, upper + height - along * height],
        ]
    )


def _share(logit: float) -> float:
    return 1.0 / (1.0 + exp(-logit))
