"""Pictures of users that cover the target: as a file of grey levels, and made from any picture.

The file is a plain PGM (netpbm.sourceforge.net/doc/pgm.html), so that a manifest can have it and
no decoder of pictures decides a result:

    P2
    400 124
    255
    112 113 ...

It is as wide and as high as the target's top face, with two pixels for each texel.
"""

import numpy as np
from numpy.typing import NDArray

from seamark.sim.files.library import FileInvalid, Library

Grey = NDArray[np.uint8]  # (HEIGHT, WIDTH)

WIDTH, HEIGHT = 400, 124  # [px] D: of a face of 0.42 m x 0.13 m, two pixels to each 2.1 mm
SPREAD_LEAST = 8  # [grey] E: standard deviation below which a tracker sees noise, once amplified
SUFFIXES = (".png", ".jpg", ".jpeg", ".pgm")
_HEAD = f"P2\n{WIDTH} {HEIGHT}\n255\n".encode()
BYTES_MAX = len(_HEAD) + 4 * WIDTH * HEIGHT
_DIGITS_MAX = 3  # of a number
_PER_LINE = 16  # numbers: "No line should be longer than 70 characters"


def read(content: bytes) -> Grey:
    """Return the grey levels (HEIGHT, WIDTH) of a file.

    Raises
    ------
    FileInvalid
        It is none of these files, or has next to no contrast.
    """
    if not content.startswith(_HEAD) or len(content) > BYTES_MAX:
        raise FileInvalid(f"The file is not a plain PGM of {WIDTH} x {HEIGHT} grey levels.")
    numbers = content[len(_HEAD) :].split()
    if len(numbers) != WIDTH * HEIGHT or not all(map(_is_number, numbers)):
        raise FileInvalid(f"The file must have {WIDTH * HEIGHT} numbers from 0 to 255.")
    grey = np.array(list(map(int, numbers)))
    if grey.max() > 255:
        raise FileInvalid("A grey level is at most 255.")
    total, squares = int(grey.sum()), int((grey * grey).sum())  # exact, on every processor
    if grey.size * squares - total * total < (SPREAD_LEAST * grey.size) ** 2:
        raise FileInvalid(
            "The picture has next to no contrast where it covers the target: its middle, "
            f"{WIDTH / HEIGHT:.1f} times as wide as high. Transparency is ignored."
        )
    return grey.reshape(HEIGHT, WIDTH).astype(np.uint8)


def write(grey: Grey) -> bytes:
    """Return the file of grey levels (HEIGHT, WIDTH)."""
    numbers = list(map(str, grey.ravel().tolist()))
    lines = [" ".join(numbers[at : at + _PER_LINE]) for at in range(0, len(numbers), _PER_LINE)]
    return _HEAD + ("\n".join(lines) + "\n").encode()


def _is_number(digits: bytes) -> bool:
    return digits.isdigit() and len(digits) <= _DIGITS_MAX


def _converted(content: bytes) -> bytes:
    if content.startswith(_HEAD):
        return content
    from seamark.sim.files.picture_conversion import middle  # noqa: PLC0415 - loads OpenCV

    return write(middle(content, WIDTH, HEIGHT))


LIBRARY = Library(
    setting="target_texture",
    what="target picture",
    mark="picture",
    entry="target_file",
    suffixes=SUFFIXES,
    bytes_max=4 << 20,  # of the picture from which one is made
    read=read,
    converted=_converted,
)
