"""What the face of a box looks like, in face coordinates.

They have their origin in the middle of the face, x to the right and y downwards as one reads the
letters, in lengths of the face. All is painted by `lettering.label`, as the camera sees it.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from seamark.sim.camera.lettering import GLYPHS, TEXT, WHITE, label
from seamark.sim.camera.target import TEXEL_M

Texels = NDArray[np.float32]  # 0 is ink, 1 is paint

_LENGTH_M, _WIDTH_M = 0.3, 0.2  # of the face
HALF_LENGTH, HALF_WIDTH = 0.5, 0.5 * _WIDTH_M / _LENGTH_M
# Each letter has a field; the line of letters is as `label` paints it.
LETTERS, ALPHABET = len(TEXT), len(GLYPHS)
UNKNOWN = ALPHABET  # the number of the mean of all letters
RIGHT = np.array([list(GLYPHS).index(letter) for letter in TEXT])
_HEIGHT = 0.8 / 5.5  # of a letter
PITCH = 0.784 * _HEIGHT
LEFT = -2.7 * _HEIGHT - 0.5 * (PITCH - 4.0 / 6.0 * _HEIGHT)  # of the first field
TOP = (0.42 - 0.5) * _WIDTH_M / _LENGTH_M - 0.65 * _HEIGHT
BOTTOM = TOP + 1.3 * _HEIGHT
_BLURS = 6  # E: until the soft picture is as one that a camera sees from afar


class Pictures(NamedTuple):
    """Pictures of the whole face, (n, rows, columns)."""

    sharp: Texels  # n = ALPHABET + 1: all seven letters are this one, or UNKNOWN
    soft: Texels  # n = 1: unknown letters, blurred
    either: Texels  # n = 1: the mean of the soft one and itself after half a turn


@lru_cache(maxsize=1)
def pictures() -> Pictures:
    """Return the pictures of a face."""
    every = [label(_LENGTH_M, _WIDTH_M, TEXEL_M, WHITE, 0.0, one * LETTERS) for one in GLYPHS]
    unknown = sum(every[1:], start=every[0]) / ALPHABET
    soft = unknown
    for _ in range(_BLURS):
        soft = _blurred(_blurred(soft).T).T
    either = 0.5 * (soft + soft[::-1, ::-1])
    sharp, *others = (
        (np.stack(some) / WHITE).astype(np.float32)
        for some in ([*every, unknown], [soft], [either])
    )
    return Pictures(sharp, *others)


def _blurred(picture: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a picture blurred along its columns, edges repeated."""
    rows = np.concatenate([picture[:1], picture[:1], picture, picture[-1:], picture[-1:]])
    return np.asarray(0.25 * (rows[:-4] + rows[4:]) + 0.5 * rows[2:-2])
