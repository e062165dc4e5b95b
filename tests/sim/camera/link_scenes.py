"""Scenes of bodies on links, and a slow renderer of them by other means, in double precision."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from seamark.sim.camera import Optics, Water, lettering
from seamark.sim.camera.bodies import Bodies, Placed
from seamark.sim.camera.link_camera import LinkCamera
from seamark.sim.camera.seabed import SEABED_SEED, TEXEL_M, texels
from seamark.sim.multibody.assembly import Frame, Look
from seamark.sim.vehicles.solids import Paint, Solid

Array = NDArray[np.float64]
Bilinear = Callable[..., Array]

OPTICS = Optics(width=320, height=240, focal_px=220.0)
LINKS = ("camera", "first", "second")
SEABED_M = 5.0
LETTERS_TEXEL_M = 0.0021
EYE = Frame("camera", np.zeros(3), np.eye(3))


def turned(roll: float, pitch: float, yaw: float) -> Array:
    """Rotation from three elementary turns."""
    (sr, cr), (sp, cp), (sy, cy) = ((math.sin(a), math.cos(a)) for a in (roll, pitch, yaw))
    about_x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    about_y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    about_z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return about_z @ about_y @ about_x


def placed(*places: tuple[Array, tuple[float, float, float]]) -> Placed:
    """Links at rest: rotation and position of each, those that are not given at the origin."""
    rotation, position = np.tile(np.eye(3), (len(LINKS), 1, 1)), np.zeros((len(LINKS), 3))
    for k, (turn, point) in enumerate(places):
        rotation[k], position[k] = turn, point
    return Placed(rotation, position, np.zeros((len(LINKS), 6)))


def look(
    shape: str,
    size: tuple[float, float, float],
    colour: str,
    *,
    link: str | None = None,
    at: tuple[float, float, float] = (0.0, 0.0, 0.0),
    turn: Array | None = None,
    lettered: bool = False,
) -> Look:
    """A solid on a link, at a place in axes that are turned."""
    on = Frame(link, np.array(at), np.eye(3) if turn is None else turn)
    return Look(on, Solid(shape, size, (0.0, 0.0, 0.0), Paint(colour), lettered))  # type: ignore[arg-type]


def camera(looks: list[Look], water: Water | None = None, **options: object) -> LinkCamera:
    """A camera on the first link, along its x axis."""
    settings: dict[str, object] = {"mount": EYE, "seabed_m": SEABED_M, "noise_seed": 3}
    bodies = Bodies(looks, LINKS)
    return LinkCamera(OPTICS, water or Water(), bodies, **settings | options)  # type: ignore[arg-type]


def average(of: LinkCamera, links: Placed, frames: int = 64) -> Array:
    """Mean image: the light without most of its noise."""
    return np.mean([of.grey(links, k) for k in range(frames)], axis=0)


def through(water: Water, depth: Array, slant: Array, light: Array) -> Array:
    """Grey values seen through water; beyond the horizon is its veil."""
    veil, c = 255.0 * water.veil[1], water.attenuation[1]
    sky = np.isinf(depth)
    path = {"beer": c * slant, "uwsim": (c * np.where(sky, 0.0, depth)) ** 2}[water.law]
    return np.where(sky, veil, (light - veil) * np.exp(-path) + veil)


@dataclass
class SlowRenderer:
    """Ray-casts every sample of every pixel: seabed, planes of boxes, quadrics, balls."""

    looks: list[Look]
    water: Water
    bilinear: Bilinear
    samples: int = 4

    def grey(self, links: Placed) -> Array:
        """Image (H, W) in grey levels, without noise and rounding."""
        return self.greys(links, [self.water])[0]

    def greys(self, links: Placed, waters: Sequence[Water]) -> list[Array]:
        """Images of the same in several waters, for which rays are cast once."""
        v, u = (c.ravel().astype(float) for c in np.indices((OPTICS.height, OPTICS.width)))
        n, totals = self.samples, np.zeros((len(waters), OPTICS.height * OPTICS.width))
        for k in range(n * n):
            du, dv = (k % n + 0.5) / n - 0.5, (k // n + 0.5) / n - 0.5
            cast = self.cast(links, u + du, v + dv)
            totals += [through(water, *cast) for water in waters]
        return list((totals / n**2).reshape(-1, OPTICS.height, OPTICS.width))

    def sampled(self, links: Placed, u: Array, v: Array) -> Array:
        """Grey values at image points."""
        return through(self.water, *self.cast(links, u, v))

    def cast(self, links: Placed, u: Array, v: Array) -> tuple[Array, Array, Array]:
        """Depth, distance along the ray, and grey value without water at image points."""
        turn, origin = links.rotation[0] @ EYE.turn, links.position[0]
        x = (u - OPTICS.principal_px[0]) / OPTICS.focal_px
        y = (v - OPTICS.principal_px[1]) / OPTICS.focal_px
        rays = turn @ np.array([np.ones_like(x), x, y])
        depth, light = self.seabed(origin, rays)
        for each in self.looks:
            link = None if each.on.link is None else LINKS.index(each.on.link)
            axes, centre = each.on.turn, each.on.point
            if link is not None:
                centre = links.rotation[link] @ centre + links.position[link]
                axes = links.rotation[link] @ axes
            t, normal, albedo = self.hit(each.solid, axes.T @ (origin - centre), axes.T @ rays)
            towards = np.array([0.29884, -0.29884, -0.90631])
            cosine = towards @ (axes @ normal)
            shade = (0.6 + 0.4 * cosine) / (0.6 + 0.4 * 0.90631)
            nearer = t < depth
            light = np.where(nearer, 255.0 * albedo * shade, light)
            depth = np.where(nearer, t, depth)
        slant = np.where(np.isinf(depth), 0.0, depth) * np.linalg.norm(rays, axis=0)
        return depth, slant, light

    def seabed(self, origin: Array, rays: Array) -> tuple[Array, Array]:
        """Depth, and grey value; infinite depth from the horizon upwards."""
        down = np.where(rays[2] > 1e-9, rays[2], np.nan)
        height = SEABED_M - origin[2]
        depth = height / down
        depth = np.where(depth < 1000.0, depth, np.inf)
        ground = sand()
        near = np.where(np.isinf(depth), 0.0, depth)
        a, b = origin[0] + near * rays[0], origin[1] + near * rays[1]
        value = self.bilinear(ground, a / TEXEL_M - 0.5, b / TEXEL_M - 0.5, wrap=True)
        sharp = 2.0 * height * OPTICS.focal_px * TEXEL_M
        contrast = np.minimum(sharp / np.maximum(near, 1e-3) ** 2, 1.0)
        return depth, ground.mean() + contrast * (value - ground.mean())

    def hit(self, solid: Solid, origin: Array, rays: Array) -> tuple[Array, Array, Array]:
        """Depth, outward normal and albedo in the axes of a body."""
        half = 0.5 * np.array(solid.size)
        green = int(solid.paint.colour[3:5], 16) / 255.0
        albedo = np.full(rays.shape[1], green)
        if solid.shape == "box":
            return self.hit_box(solid, half, origin, rays, albedo)
        radius = half[1] if solid.shape != "sphere" else half[0]
        length = {"cylinder": half[0], "capsule": half[0] - radius, "sphere": 0.0}[solid.shape]
        candidates = [side(length, radius, origin, rays)]
        if solid.shape == "cylinder":
            candidates += [disc(s * length, radius, origin, rays) for s in (-1.0, 1.0)]
        else:
            candidates += [ball(s * length, radius, origin, rays) for s in (-1.0, 1.0)]
        depth, normal = np.full(rays.shape[1], np.inf), np.zeros_like(rays)
        for t, n in candidates:
            nearer = t < depth
            depth, normal = np.where(nearer, t, depth), np.where(nearer, n, normal)
        return depth, normal, albedo

    def hit_box(
        self, solid: Solid, half: Array, origin: Array, rays: Array, albedo: Array
    ) -> tuple[Array, Array, Array]:
        """The nearest of six rectangles."""
        depth, normal = np.full(rays.shape[1], np.inf), np.zeros_like(rays)
        for axis in range(3):
            for sign in (-1.0, 1.0):
                if sign * origin[axis] <= half[axis]:
                    continue
                t = (sign * half[axis] - origin[axis]) / rays[axis]
                place = origin[:, None] + t * rays
                others = [k for k in range(3) if k != axis]
                hit = (t > 1e-3) & (t < depth)
                for k in others:
                    hit &= np.abs(place[k]) <= half[k]
                depth = np.where(hit, t, depth)
                outward = np.zeros((3, 1))
                outward[axis] = sign
                normal = np.where(hit, outward, normal)
                if solid.lettered:
                    texel = self.letters(solid, half, axis, sign, place)
                    albedo = np.where(hit, texel, albedo)
        return depth, normal, albedo

    def letters(self, solid: Solid, half: Array, axis: int, sign: float, place: Array) -> Array:
        """What is painted on a face: one reads it from outside, with z (or y) downwards."""
        right, down = {
            (0, 1.0): (-1, (1, 2)),
            (0, -1.0): (1, (1, 2)),
            (1, 1.0): (1, (0, 2)),
            (1, -1.0): (-1, (0, 2)),
            (2, 1.0): (1, (0, 1)),
            (2, -1.0): (1, (0, 1)),
        }[axis, sign]
        flip = -1.0 if (axis, sign) == (2, 1.0) else 1.0
        a, b = down
        green = int(solid.paint.colour[3:5], 16) / 255.0
        painted = lettering.label(2 * half[a], 2 * half[b], LETTERS_TEXEL_M, green, lettering.BLACK)
        grey = np.floor(painted * 255 + 0.5)
        rows, columns = grey.shape
        u = (right * place[a] / half[a] + 1) / 2 * columns - 0.5
        v = (flip * place[b] / half[b] + 1) / 2 * rows - 0.5
        u, v = np.nan_to_num(u), np.nan_to_num(v)
        u, v = np.clip(u, 0, columns - 1), np.clip(v, 0, rows - 1)
        return self.bilinear(grey, u, v, wrap=False) / 255.0


@cache  # each sample of an image asks for it
def sand() -> Array:
    """Grey values of the seabed's texels."""
    return texels(SEABED_SEED, 1).astype(float)


def side(length: float, radius: float, origin: Array, rays: Array) -> tuple[Array, Array]:
    """Where rays enter the side of a cylinder along x."""
    a = rays[1] ** 2 + rays[2] ** 2
    b = origin[1] * rays[1] + origin[2] * rays[2]
    c = origin[1] ** 2 + origin[2] ** 2 - radius**2
    root = np.sqrt(np.where(b * b - a * c > 0, b * b - a * c, np.nan))
    t = (-b - root) / a
    place = origin[:, None] + t * rays
    hit = (np.abs(place[0]) <= length) & (t > 1e-3)
    return np.where(hit, t, np.inf), np.array([0 * t, place[1] / radius, place[2] / radius])


def disc(x: float, radius: float, origin: Array, rays: Array) -> tuple[Array, Array]:
    """Where rays meet the end of a cylinder from outside."""
    outward = np.array([[math.copysign(1.0, x)], [0.0], [0.0]]) + 0 * rays
    if origin[0] * math.copysign(1.0, x) <= abs(x):
        return np.full(rays.shape[1], np.inf), outward
    t = (x - origin[0]) / rays[0]
    place = origin[:, None] + t * rays
    hit = (place[1] ** 2 + place[2] ** 2 <= radius**2) & (t > 1e-3)
    return np.where(hit, t, np.inf), outward


def ball(x: float, radius: float, origin: Array, rays: Array) -> tuple[Array, Array]:
    """Where rays enter a ball on the x axis."""
    start = origin - np.array([x, 0.0, 0.0])
    a, b, c = (rays**2).sum(axis=0), start @ rays, start @ start - radius**2
    root = np.sqrt(np.where(b * b - a * c > 0, b * b - a * c, np.nan))
    t = (-b - root) / a
    hit = t > 1e-3
    return np.where(hit, t, np.inf), (start[:, None] + t * rays) / radius
