"""A canvas for the pictures of link previews: text, lines and bars drawn by OpenCV."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

WIDTH, HEIGHT = 1200, 630  # [px] the size that services with link previews ask for
JPEG_QUALITY = 88
_SUBPIXEL_BITS = 4  # OpenCV draws at sixteenths of a pixel
_REGULAR, _BOLD = 400, 700  # weights of the font
_MARGIN = 0.05  # of a chart above and below its lines
Colour = tuple[int, int, int]  # blue, green, red
Image = NDArray[np.uint8]
Line = NDArray[np.float64]

BACKGROUND: Colour = (41, 42, 11)
PANEL: Colour = (54, 50, 18)
TEXT: Colour = (248, 246, 234)
MUTED: Colour = (200, 190, 165)
GRID: Colour = (88, 82, 44)
RUNS: tuple[Colour, ...] = (  # of runs 1 to 5: the colours of the dark theme in tokens.css
    (209, 195, 79),
    (106, 154, 255),
    (255, 164, 179),
    (194, 143, 255),
    (79, 217, 205),
)


@dataclass(frozen=True, slots=True)
class Box:
    """A rectangle [px], from the upper left corner."""

    x: int
    y: int
    width: int
    height: int


class Canvas:
    """A picture that is being drawn. Not for several threads at once."""

    def __init__(self) -> None:
        self.image: Image = np.full((HEIGHT, WIDTH, 3), BACKGROUND, np.uint8)
        self._font = cv2.FontFace("sans")

    def text(
        self,
        text: str,
        at: tuple[int, int],
        size: int,
        *,
        width: int,
        colour: Colour = TEXT,
        bold: bool = False,
    ) -> None:
        """Write a line whose baseline starts at `at`, shortened to `width` [px]."""
        weight = _BOLD if bold else _REGULAR
        shown = self._fitted(text, size, weight, width)
        cv2.putText(self.image, shown, at, colour, self._font, size, weight)

    def _fitted(self, text: str, size: int, weight: int, width: int) -> str:
        """Return as much of a text as fits."""
        if self._width(text, size, weight) <= width:
            return text
        kept = len(text)
        while kept and self._width(f"{text[:kept]}…", size, weight) > width:
            kept -= 1
        return f"{text[:kept].rstrip()}…"

    def _width(self, text: str, size: int, weight: int) -> int:
        box = cv2.getTextSize((WIDTH, HEIGHT), text, (0, 0), self._font, size, weight)
        return int(box[2])

    def panel(self, box: Box, colour: Colour = PANEL) -> None:
        """Fill a rectangle."""
        corner = (box.x + box.width, box.y + box.height)
        cv2.rectangle(self.image, (box.x, box.y), corner, colour, cv2.FILLED)

    def paste(self, picture: Image, box: Box) -> None:
        """Fill a box with a picture, cut to its shape."""
        height, width = picture.shape[:2]
        scale = max(box.width / width, box.height / height)
        size = (max(round(width * scale), box.width), max(round(height * scale), box.height))
        scaled = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
        x, y = (size[0] - box.width) // 2, (size[1] - box.height) // 2
        cut = scaled[y : y + box.height, x : x + box.width]
        self.image[box.y : box.y + box.height, box.x : box.x + box.width] = cut

    def chart(self, box: Box, lines: Sequence[tuple[Line, Line]]) -> None:
        """Draw lines (x, y) over common axes, each in the colour of its run; nan is a gap."""
        self.panel(box)
        for share in (0.25, 0.5, 0.75):
            y = round(box.y + share * box.height)
            cv2.line(self.image, (box.x, y), (box.x + box.width, y), GRID, 1)
        xs, ys = (
            np.concatenate([line[axis] for line in lines] or [np.empty(0)]) for axis in (0, 1)
        )
        if not np.isfinite(ys).any():
            return
        x_end = float(np.max(xs)) or 1.0
        low, high = min(float(np.nanmin(ys)), 0.0), max(float(np.nanmax(ys)), 0.0)
        span = (high - low) or 1.0
        for index, (times, values) in enumerate(lines):
            across = box.x + times / x_end * box.width
            down = box.y + (_MARGIN + (1.0 - 2.0 * _MARGIN) * (high - values) / span) * box.height
            self._polyline(np.stack([across, down], axis=1), index)

    def _polyline(self, points: Line, index: int) -> None:
        """Draw the parts of a line between its gaps."""
        gaps = np.flatnonzero(~np.isfinite(points).all(axis=1))
        for part in np.split(points, gaps):
            whole = part[np.isfinite(part).all(axis=1)]
            fixed = np.round(whole * (1 << _SUBPIXEL_BITS)).astype(np.int32)
            if len(fixed) > 1:
                colour = RUNS[index % len(RUNS)]
                cv2.polylines(self.image, [fixed], False, colour, 2, cv2.LINE_AA, _SUBPIXEL_BITS)

    def jpeg(self) -> bytes:
        """Return the finished picture."""
        done, encoded = cv2.imencode(".jpg", self.image, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
        if not done:
            raise RuntimeError("OpenCV could not encode the picture")
        data: bytes = encoded.tobytes()
        return data
