"""Draws things: size, form, colour, lettering or code, and how each lies on the bottom.

Nothing is taken from a picture: each thing is new, so that no memory of training images suffices.
Ranges are our estimates (E) of what is found on a sea bottom.
"""

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from seamark.sim.camera.bottom import shapes
from seamark.sim.camera.bottom.painter import Place
from seamark.sim.camera.bottom.shapes import Colour, Shape
from seamark.sim.camera.lettering import GLYPHS, strokes
from seamark.sim.numerics.libm import PI, cos, sin

Range = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Kind:
    """The range of a kind: size [m] and colours, of which each thing has two."""

    length: Range
    width: Range  # of its length
    height: Range  # [m]; of a body of revolution: derived from its width
    colours: tuple[Colour, ...]
    second: tuple[Colour, ...] = ((0.8, 0.8, 0.8),)
    buried: float = 0.5  # the most of it below the sand


_BLACK: tuple[Colour, ...] = ((0.05, 0.05, 0.055), (0.075, 0.075, 0.08), (0.06, 0.055, 0.05))
_WHITE: tuple[Colour, ...] = ((0.80, 0.80, 0.80), (0.85, 0.75, 0.25))
_CLAY: tuple[Colour, ...] = ((0.52, 0.30, 0.19), (0.44, 0.27, 0.18), (0.58, 0.42, 0.30))
_PAINTS: tuple[Colour, ...] = (
    *((0.70, 0.55, 0.10), (0.62, 0.22, 0.10), (0.15, 0.25, 0.42)),
    *((0.30, 0.32, 0.33), (0.55, 0.56, 0.55), (0.16, 0.33, 0.20)),
)
_ROCKS: tuple[Colour, ...] = ((0.30, 0.28, 0.25), (0.18, 0.17, 0.16), (0.42, 0.38, 0.32))
_SHELLS: tuple[Colour, ...] = ((0.78, 0.72, 0.64), (0.70, 0.52, 0.44), (0.55, 0.46, 0.40))
_GLASS: tuple[Colour, ...] = ((0.07, 0.20, 0.10), (0.22, 0.12, 0.05), (0.50, 0.56, 0.56))
_PRINT: tuple[Colour, ...] = ((0.60, 0.08, 0.08), (0.10, 0.22, 0.50), (0.75, 0.72, 0.70))
_WOOD: tuple[Colour, ...] = ((0.34, 0.25, 0.16), (0.24, 0.18, 0.13), (0.45, 0.36, 0.26))
_STARS: tuple[Colour, ...] = ((0.62, 0.28, 0.12), (0.52, 0.16, 0.14), (0.42, 0.34, 0.40))
_ZINC: tuple[Colour, ...] = ((0.58, 0.60, 0.61), (0.46, 0.47, 0.47), (0.66, 0.66, 0.64))

KINDS: dict[str, Kind] = {
    "box": Kind((0.36, 0.50), (0.29, 0.36), (0.10, 0.15), _BLACK, _WHITE, 0.3),
    "amphora": Kind((0.45, 0.70), (0.42, 0.54), (0.0, 0.0), _CLAY),
    "pipe": Kind((0.40, 0.70), (0.18, 0.30), (0.0, 0.0), _PAINTS, _PAINTS),
    "panel": Kind((0.36, 0.52), (0.60, 0.80), (0.03, 0.05), _PAINTS, (*_WHITE, *_PRINT), 0.2),
    "connector": Kind((0.30, 0.46), (0.20, 0.28), (0.0, 0.0), _PAINTS, (*_PAINTS, *_ZINC)),
    "anode": Kind((0.34, 0.52), (0.17, 0.24), (0.04, 0.06), _ZINC),
    "aruco": Kind((0.12, 0.26), (1.0, 1.0), (0.01, 0.02), _WHITE, buried=0.1),
    "apriltag": Kind((0.14, 0.28), (1.0, 1.0), (0.01, 0.02), _WHITE, buried=0.1),
    "rock": Kind((0.18, 0.46), (0.60, 1.0), (0.06, 0.14), _ROCKS),
    "shell": Kind((0.09, 0.18), (0.8, 1.1), (0.02, 0.04), _SHELLS, buried=0.4),
    "bottle": Kind((0.22, 0.34), (0.24, 0.34), (0.0, 0.0), _GLASS, _PRINT),
    "can": Kind((0.12, 0.18), (0.45, 0.60), (0.0, 0.0), _PRINT, _PRINT),
    "plank": Kind((0.40, 0.70), (0.14, 0.26), (0.02, 0.04), _WOOD),
    "slab": Kind((0.34, 0.52), (0.26, 0.42), (0.06, 0.15), _BLACK),
    "starfish": Kind((0.16, 0.30), (1.0, 1.0), (0.03, 0.05), _STARS, _SHELLS, 0.2),
    "false-marker": Kind((0.12, 0.28), (1.0, 1.0), (0.01, 0.02), _WHITE, buried=0.1),
}
NAMES = tuple(KINDS)  # in the order of the kinds in `shapes`: objects, then decoys
OBJECTS = shapes.ROCK  # how many of them are objects
_ROUND = frozenset({"amphora", "pipe", "connector", "bottle", "can"})
_HALF_AND_MORE = 1.5  # height of a body of revolution that lies half sunk, in radii
_TEXT_LETTERS = (4, 7)  # fewest and most on a box
_LETTER_HEIGHT, _LETTER_PITCH = 0.46, 5.8 / 6.0  # of the box's width, of a letter's height
_NO_STROKES, _NO_BITS = np.zeros((0, 4)), np.zeros((0, 0), np.uint8)
_SHARES = 20  # random numbers of a thing


@dataclass(frozen=True, slots=True, kw_only=True)
class Thing:
    """One thing on the bottom."""

    name: str  # of NAMES
    shape: Shape
    place: Place
    text: str = ""  # on a box
    code: int = -1  # number of a marker in its dictionary

    @property
    def number(self) -> int:
        """Its kind, counted from 1."""
        return self.shape.kind + 1

    def corners(self, seabed_m: float) -> NDArray[np.float64]:
        """Return the corners of its plan rectangle, (4, 3) [m] NED, on the bottom."""
        a, b = 0.5 * self.shape.length, 0.5 * self.shape.width
        x = np.array([-a, a, a, -a])
        y = np.array([-b, -b, b, b])
        c, s = self.place.cosine, self.place.sine
        north, east = self.place.north + c * x - s * y, self.place.east + s * x + c * y
        return np.stack([north, east, np.full(4, seabed_m)], axis=1)


def draw_thing(
    name: str, north_m: float, east_m: float, random: np.random.Generator, *, burial: float
) -> Thing:
    """Return a new thing of a kind at a place.

    Parameters
    ----------
    burial
        From 0 to 1: how much of the kind's deepest burial is reached at most.
    """
    kind, share = KINDS[name], random.random(_SHARES).tolist()
    length = _within(kind.length, share[0])
    width = length * _within(kind.width, share[1])
    height = _within(kind.height, share[2])
    if name in _ROUND:
        height = 0.5 * width * _HALF_AND_MORE
    heading = 2.0 * PI * share[3]
    text = _text(random, share[4]) if name == "box" else ""
    code, bits = _code(name, random, share[4])
    shape = Shape(
        kind=NAMES.index(name),
        length=length,
        width=width,
        height=height,
        form=np.array(share[5:13]),
        base=_toned(_one_of(kind.colours, share[13]), 0.8 + 0.4 * share[14]),
        second=_one_of(kind.second, share[15]),
        strokes=_lettering(text, length, width) if text else _NO_STROKES,
        bits=bits,
        seed=int(random.integers(1 << 20)),
    )
    place = Place(
        north=north_m,
        east=east_m,
        cosine=cos(heading),
        sine=sin(heading),
        burial=kind.buried * burial * share[16],
        growth=0.5 * share[17] * share[17],
        dust=0.5 * share[18] * share[18],
    )
    return Thing(name=name, shape=shape, place=place, text=text, code=code)


def _within(limits: Range, share: float) -> float:
    return limits[0] + (limits[1] - limits[0]) * share


def _one_of(colours: tuple[Colour, ...], share: float) -> Colour:
    return colours[int(share * len(colours))]


def _toned(colour: Colour, factor: float) -> Colour:
    red, green, blue = colour
    return (factor * red, factor * green, factor * blue)


def _text(random: np.random.Generator, share: float) -> str:
    """Return the lettering of a box."""
    fewest, most = _TEXT_LETTERS
    letters = tuple(GLYPHS)
    count = fewest + int(share * (most + 1 - fewest))
    return "".join(letters[k] for k in random.integers(len(letters), size=count).tolist())


def _lettering(text: str, length: float, width: float) -> NDArray[np.float64]:
    """Return the strokes (n, 4) [m] of a text in the middle of a box."""
    height = _LETTER_HEIGHT * width
    across = ((len(text) - 1) * _LETTER_PITCH + 4.0 / 6.0) * height
    widest = 0.82 * length
    height *= min(1.0, widest / across)
    across = min(across, widest)
    lines = strokes(
        text, x=-0.5 * across, y=-0.5 * height, height=height, pitch=_LETTER_PITCH * height
    )
    return np.array(lines)


def _code(name: str, random: np.random.Generator, share: float) -> tuple[int, NDArray[np.uint8]]:
    """Return number and bits of a marker; -1 for a pattern of no dictionary."""
    if name == "false-marker":
        return -1, _false_bits(random, 4 if share < 0.5 else 6)
    if name not in _DICTIONARIES:
        return -1, _NO_BITS
    every = _dictionary(name)
    number = int(share * len(every))
    return number, every[number]


_DICTIONARIES = {"aruco": cv2.aruco.DICT_4X4_50, "apriltag": cv2.aruco.DICT_APRILTAG_36h11}


@lru_cache(maxsize=len(_DICTIONARIES))
def _dictionary(name: str) -> tuple[NDArray[np.uint8], ...]:
    """Return the bits of all markers of a dictionary, with their black border; 1 is white."""
    markers = cv2.aruco.getPredefinedDictionary(_DICTIONARIES[name])
    side = int(markers.markerSize) + 2
    return tuple(
        (np.asarray(markers.generateImageMarker(k, side, borderBits=1)) > 127).astype(np.uint8)
        for k in range(len(markers.bytesList))
    )


def _false_bits(random: np.random.Generator, side: int) -> NDArray[np.uint8]:
    """Return a bordered pattern that differs from every marker by more than readers correct."""
    while True:
        bits = np.zeros((side + 2, side + 2), np.uint8)
        bits[1:-1, 1:-1] = random.integers(2, size=(side, side))
        if all(_differs(bits, name) for name in _DICTIONARIES):
            return bits


_CORRECTED_BITS = 11  # of 36: AprilTag's hamming distance is 11, and half of it can be corrected


def _differs(bits: NDArray[np.uint8], name: str) -> bool:
    """Return whether no turn of a pattern is one of a dictionary, errors corrected."""
    markers = _dictionary(name)
    if markers[0].shape != bits.shape:
        return True
    apart = 2 if name == "aruco" else _CORRECTED_BITS // 2 + 1
    known = np.array(markers)
    return all(
        int((known != np.rot90(bits, turn)).sum(axis=(1, 2)).min()) >= apart for turn in range(4)
    )
