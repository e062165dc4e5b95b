"""What a camera sees besides the seabed: boxes, cylinders and capsules on links that move.

They are made once from the solids of a mechanism; where its links are is said for each image.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from seamark.sim.camera import lettering
from seamark.sim.camera.seabed import packed, quantise
from seamark.sim.camera.target import TEXEL_M, Target, box_face, box_sizes
from seamark.sim.multibody.assembly import Look
from seamark.sim.numerics.arrays import Array, Integers
from seamark.sim.vehicles.solids import Solid

BOX, CYLINDER, CAPSULE = 0, 1, 2
WORLD = -1  # the link of what does not move
FACES = 6  # of a box: +x, -x, +y, -y, +z, -z
UPPER = 5
DARK = 0.3  # albedo in green below which letters are white
BODIES_MAX = 256  # in one scene
Face = NDArray[np.float64]  # (rows, columns) albedo


class Placed(NamedTuple):
    """Where links are, in the order of the mechanism.

    The twist moves the links during an exposure: velocity over ground of the origin, and angular
    velocity, in the axes of the link.
    """

    rotation: Array  # (links, 3, 3) to world axes
    position: Array  # (links, 3) [m] NED
    twist: Array  # (links, 6) [m/s, rad/s]


class Shapes(NamedTuple):
    """The bodies as compiled code reads them."""

    kind: Integers  # (n,) BOX, CYLINDER or CAPSULE; these two lie along x
    link: Integers  # (n,) link, or WORLD
    half: Array  # (n, 3) [m] half lengths; of a capsule without its ends
    centre: Array  # (n, 3) [m] in the axes of the link
    turn: Array  # (n, 3, 3) rotation to the axes of the link


class Paints(NamedTuple):
    """How bright the bodies are in one colour channel."""

    albedo: Array  # (n,) 1 where a texture says it
    texels: NDArray[np.uint16]  # packed textures of all faces, one after the other
    layout: NDArray[np.int32]  # (n, FACES, 3) offset, columns, rows; no columns without a texture


@dataclass(frozen=True, slots=True)
class _Body:
    kind: int
    link: int
    half: tuple[float, float, float]
    centre: Array
    turn: Array
    colour: tuple[float, float, float]  # albedo in red, green and blue
    face: Callable[[int, int], Face] | None = None  # of a channel and the number of a face


class Bodies:
    """The bodies of a scene.

    Parameters
    ----------
    looks : iterable
        Solids with what they are attached to, such as `Assembly.looks` or a part of them.
    links : sequence
        Names of the links in the order of `Placed`.
    target : Target
        A box on the seabed, if there is one; its letters are those of `Camera`.
    """

    def __init__(
        self, looks: Iterable[Look], links: Sequence[str], *, target: Target | None = None
    ) -> None:
        self.links = tuple(links)
        bodies = [_body(look, self.number(look.on.link)) for look in looks]
        if target is not None:
            bodies.append(_target_body(target))
        if len(bodies) > BODIES_MAX:
            raise ValueError(f"a scene has at most {BODIES_MAX} bodies, not {len(bodies)}")
        self._bodies = bodies
        self.shapes = Shapes(
            kind=np.array([body.kind for body in bodies], dtype=np.int64),
            link=np.array([body.link for body in bodies], dtype=np.int64),
            half=np.array([body.half for body in bodies], dtype=np.float64).reshape(-1, 3),
            centre=np.array([body.centre for body in bodies], dtype=np.float64).reshape(-1, 3),
            turn=np.array([body.turn for body in bodies], dtype=np.float64).reshape(-1, 3, 3),
        )

    @classmethod
    def none(cls) -> Self:
        """Return a scene of the seabed alone."""
        return cls((), ())

    def number(self, link: str | None) -> int:
        """Return the number of a link in `Placed`; WORLD for None."""
        if link is None:
            return WORLD
        if link not in self.links:
            raise ValueError(f"there is no link {link!r} among {', '.join(self.links) or 'none'}")
        return self.links.index(link)

    def paints(self, channel: int) -> Paints:
        """Return the brightness of all bodies in a channel: 0 red, 1 green, 2 blue."""
        parts: list[NDArray[np.uint16]] = [np.zeros(1, np.uint16)]
        layout = np.zeros((len(self._bodies), FACES, 3), np.int32)
        albedo = np.ones(len(self._bodies))
        offset = 1
        for number, body in enumerate(self._bodies):
            if body.face is None:
                albedo[number] = body.colour[channel]
                continue
            for side in range(FACES):
                texels = quantise(body.face(channel, side))
                layout[number, side] = offset, texels.shape[1], texels.shape[0]
                parts.append(packed(texels, wrap=False))
                offset += texels.size
        return Paints(albedo, np.concatenate(parts), layout)


def _body(look: Look, link: int) -> _Body:
    solid, on = look.solid, look.on
    x, y, z = (0.5 * length for length in solid.size)
    radius = 0.5 * (y + z)
    kind, half = {
        "box": (BOX, (x, y, z)),
        "cylinder": (CYLINDER, (x, radius, radius)),
        "capsule": (CAPSULE, (max(x - radius, 0.0), radius, radius)),
        "sphere": (CAPSULE, (0.0, x, x)),
    }[solid.shape]
    centre = on.at(solid.centre)
    face = partial(lettered_face, solid) if solid.lettered else None
    return _Body(kind, link, half, centre, on.turn, _colour(solid), face)


def _colour(solid: Solid) -> tuple[float, float, float]:
    red, green, blue = (int(solid.paint.colour[k : k + 2], 16) / 255.0 for k in (1, 3, 5))
    return red, green, blue


def lettered_face(solid: Solid, channel: int, side: int) -> Face:
    """Return a face of a box with letters, in a channel: 0 red, 1 green, 2 blue."""
    (x, y, z), colour = solid.size, _colour(solid)
    sizes = [(y, z), (y, z), (x, z), (x, z), (x, y), (x, y)]
    ink = lettering.WHITE if colour[1] < DARK else lettering.BLACK
    text = solid.text or lettering.TEXT
    return lettering.label(*sizes[side], TEXEL_M, colour[channel], ink, text)


def _target_body(target: Target) -> _Body:
    """Return the target's box; its x axis is to the right as one reads the letters, z is down."""
    right, down = target.axes()
    length, width, height = target.size_m
    # Faces of the target: top, aft, forward, left, right; it lies on the sixth.
    numbers = (4, 3, 1, 2, 0, 0)

    def face(channel: int, side: int) -> Face:
        number = numbers[side]
        return box_face(target, number, *box_sizes(target)[number], channel)

    return _Body(
        kind=BOX,
        link=WORLD,
        half=(0.5 * length, 0.5 * width, 0.5 * height),
        centre=target.origin(),
        turn=np.stack([right, down, np.array([0.0, 0.0, 1.0])], axis=1),
        colour=(1.0, 1.0, 1.0),
        face=face,
    )
