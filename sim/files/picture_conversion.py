"""From any picture to the grey levels that cover the target.

By integers alone, as OpenCV's decoders do, so that every processor makes the same file of it.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from seamark.sim.files.library import FileInvalid

Grey = NDArray[np.uint8]  # (rows, columns)

SIDE_MAX = 4096  # [px] of a picture


def middle(content: bytes, columns: int, rows: int) -> Grey:
    """Return the middle of a picture as grey levels (rows, columns), the largest part that fits.

    Raises
    ------
    FileInvalid
        It cannot be decoded, is too large, or that part has not half as many rows or columns.
    """
    try:
        image = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_GRAYSCALE)
    except (cv2.error, MemoryError):
        image = None
    if image is None:
        raise FileInvalid("The file is no PNG, JPEG or PGM that can be decoded.")
    if max(image.shape) > SIDE_MAX:
        raise FileInvalid(f"The picture may be at most {SIDE_MAX} px wide and high.")
    part = _part(np.asarray(image, np.uint8), columns, rows)
    height, width = part.shape
    if width < columns // 2 or height < rows // 2:
        raise FileInvalid(
            f"The middle of the picture that covers the target has {width} x {height} px: it needs "
            f"at least {columns // 2} x {rows // 2}."
        )
    sums = _summed(_summed(part, rows).T, columns).T  # each pixel counts rows x columns times
    return ((sums + part.size // 2) // part.size).astype(np.uint8)


def _part(image: Grey, columns: int, rows: int) -> Grey:
    """Return the largest part around the middle with these proportions."""
    height, width = image.shape
    high, wide = min(height, width * rows // columns), min(width, height * columns // rows)
    row, column = (height - high) // 2, (width - wide) // 2
    return image[row : row + high, column : column + wide]


def _summed(values: Grey | NDArray[np.int64], count: int) -> NDArray[np.int64]:
    """Return sums over `count` equal parts of the first axis, each value counted `count` times."""
    total = np.zeros((len(values) + 1, values.shape[1]), np.int64)
    np.cumsum(values, axis=0, out=total[1:])
    whole, rest = np.divmod(np.arange(count + 1) * len(values), count)
    after = values[np.minimum(whole, len(values) - 1)]  # at the end, `rest` is 0
    ends = count * total[whole] + rest[:, None] * after
    return np.diff(ends, axis=0)
