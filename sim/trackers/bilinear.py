"""Grey values between pixels, compiled, for trackers that sample images themselves."""

from typing import Any

from numba import njit
from numpy.typing import NDArray


@njit(cache=True, error_model="numpy")
def grey_between(image: NDArray[Any], x: float, y: float) -> float:
    """Return the bilinear grey value of an image (H, W) at a finite place [px].

    Outside the image it is that of the nearest pixel.
    """
    x = min(max(x, 0.0), image.shape[1] - 1.0)
    y = min(max(y, 0.0), image.shape[0] - 1.0)
    column, row = int(x), int(y)
    after, below = min(column + 1, image.shape[1] - 1), min(row + 1, image.shape[0] - 1)
    right, down = x - column, y - row
    upper = (1.0 - right) * image[row, column] + right * image[row, after]
    lower = (1.0 - right) * image[below, column] + right * image[below, after]
    value: float = (1.0 - down) * upper + down * lower
    return value
