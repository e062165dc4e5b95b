"""Targets to choose from, and what covers them and the seabed.

Light, so that forms need not load the camera.
"""

from typing import NamedTuple

from seamark.sim.physics import constants

_LENGTH_M, _WIDTH_M = constants.TARGET_SIZE_M.value
_HEIGHT_M = constants.TARGET_HEIGHT_M.scalar


class TargetShape(NamedTuple):
    """A box on the bottom."""

    label: str
    length_m: float
    width_m: float
    height_m: float
    lettered: bool  # with name, bolts and worn rim; otherwise a single dark tone


# E: the plain one shows a tracker nothing but its edges, the others another shape.
TARGETS: dict[str, TargetShape] = {
    "lettered": TargetShape("Black box with letters", _LENGTH_M, _WIDTH_M, _HEIGHT_M, True),
    "plain": TargetShape("Plain black box", _LENGTH_M, _WIDTH_M, _HEIGHT_M, False),
    "long": TargetShape("Long box with letters", 0.80, _WIDTH_M, _HEIGHT_M, True),
    "square": TargetShape("Square box with bolts", 0.25, 0.25, _HEIGHT_M, True),
}

RECOVERED_BOX = TargetShape("Black box with a handle", 0.3, 0.2, 0.2, True)  # as its file has it

LETTERS, SAND = "letters", "sand"  # drawn by the camera itself; the others are pictures
PICTURES = {
    "mosaic": "Painted: mosaic",
    "mottle": "Painted: mottled",
    "brick": "Photograph: bricks",
    "camera": "Photograph: man with a camera",
    "coffee": "Photograph: coffee cup",
    "grass": "Photograph: grass",
    "gravel": "Photograph: gravel",
}
TARGET_TEXTURES = {LETTERS: "Painted: letters", **PICTURES}
SEABED_TEXTURES = {
    SAND: "Painted: sand",
    **{name: PICTURES[name] for name in ("brick", "grass", "gravel")},
}
