"""What a vehicle looks like in the scene: simple solids, which no simulation uses."""

from dataclasses import dataclass
from typing import Literal, NamedTuple

Point = tuple[float, float, float]
Shape = Literal["box", "cylinder", "capsule", "sphere"]  # cylinders and capsules lie along x


class Paint(NamedTuple):
    """A colour; where several vehicles are shown together, that of the run replaces a livery."""

    colour: str  # CSS
    livery: bool = False


DARK, METAL, GLASS, WHITE = map(Paint, ("#20262b", "#9fb0ba", "#0e2a3a", "#e9f0f2"))
YELLOW, BLUE, FOAM = (Paint(colour, livery=True) for colour in ("#f2b61d", "#1668b8", "#2f8fdd"))


@dataclass(frozen=True, slots=True)
class Solid:
    """One solid along the body axes: x forward, y starboard, z down.

    Cameras see letters on the faces of a box that is `lettered`: its text, or the usual one of
    `camera.lettering`.
    """

    shape: Shape
    size: Point  # [m] whole lengths
    centre: Point  # [m]
    paint: Paint
    lettered: bool = False
    text: str = ""
