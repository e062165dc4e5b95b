"""A slow renderer of the same scene, by other means: rays against a box, in double precision."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from seamark.sim.camera import (
    CURRENTS,
    VISIBILITY,
    Camera,
    Optics,
    Target,
    Water,
    lettering,
    start_pose,
)
from seamark.sim.camera.seabed import TEXEL_M
from seamark.sim.camera.target import SHADES
from seamark.sim.camera.target import TEXEL_M as FACE_TEXEL_M
from tests.sim.camera.link_scenes import sand

Array = NDArray[np.float64]


def rotation(pose: Array) -> Array:
    """Body to world, from three elementary turns."""
    r, p, y = pose[3:]
    turn_x = np.array([[1, 0, 0], [0, math.cos(r), -math.sin(r)], [0, math.sin(r), math.cos(r)]])
    turn_y = np.array([[math.cos(p), 0, math.sin(p)], [0, 1, 0], [-math.sin(p), 0, math.cos(p)]])
    turn_z = np.array([[math.cos(y), -math.sin(y), 0], [math.sin(y), math.cos(y), 0], [0, 0, 1]])
    return turn_z @ turn_y @ turn_x


def bilinear(texels: Array, u: Array, v: Array, *, wrap: bool) -> Array:
    rows, columns = texels.shape
    iu, iv = np.floor(u).astype(int), np.floor(v).astype(int)
    fu, fv = u - iu, v - iv

    def at(i: NDArray[np.int64], j: NDArray[np.int64]) -> Array:
        if wrap:
            return texels[j % rows, i % columns]
        return texels[np.clip(j, 0, rows - 1), np.clip(i, 0, columns - 1)]

    top = at(iu, iv) * (1 - fu) + at(iu + 1, iv) * fu
    return top * (1 - fv) + (at(iu, iv + 1) * (1 - fu) + at(iu + 1, iv + 1) * fu) * fv


class Reference:
    """Ray-casts every sample of every pixel against the seabed and the box's six planes."""

    def __init__(self, optics: Optics, water: Water, target: Target, samples: int) -> None:
        self.optics, self.water, self.target, self.samples = optics, water, target, samples

    def rays(self, pose: Array, u: Array, v: Array) -> tuple[Array, Array]:
        """Origin (3,) and directions (3, n) in the world; direction's optical part is 1."""
        o, turn = self.optics, rotation(pose)
        x = (u - o.principal_px[0]) / o.focal_px
        y = (v - o.principal_px[1]) / o.focal_px
        return pose[:3] + turn @ np.array(o.mount_m), turn @ np.array([-y, x, np.ones_like(x)])

    def hits(self, origin: Array, ray: Array) -> tuple[Array, NDArray[np.int64], Array, Array]:
        """Depth, face (-1 seabed) and place along both edges (m) of the nearest hit."""
        t = self.target
        depth = (t.seabed_m - origin[2]) / ray[2]
        face = np.full(depth.shape, -1)
        a, b = origin[0] + depth * ray[0], origin[1] + depth * ray[1]
        for k, plane in enumerate(t.faces()):
            p0, e1, e2, normal = plane.reshape(4, 3)
            towards = normal @ ray
            z = (normal @ (p0 - origin)) / np.where(towards == 0, np.nan, towards)
            point = origin[:, None] + z * ray - p0[:, None]
            s = e1 @ point / np.linalg.norm(e1)
            r = e2 @ point / np.linalg.norm(e2)
            hit = (z > 0) & (z < depth) & (s >= 0) & (r >= 0)
            hit &= (s <= np.linalg.norm(e1)) & (r <= np.linalg.norm(e2))
            depth, face = np.where(hit, z, depth), np.where(hit, k, face)
            a, b = np.where(hit, s, a), np.where(hit, r, b)
        return depth, face, a, b

    def shade(self, face: NDArray[np.int64], a: Array, b: Array) -> Array:
        ground = sand()
        out = bilinear(ground, a / TEXEL_M - 0.5, b / TEXEL_M - 0.5, wrap=True)
        t = self.target
        sizes = [(t.length_m, t.width_m)] + [(t.length_m, t.height_m)] * 2
        sizes += [(t.width_m, t.height_m)] * 2
        for k, (length, width) in enumerate(sizes):
            texels = np.floor(
                lettering.face(length, width, FACE_TEXEL_M, 1) * SHADES[k] * 255 + 0.5
            )
            rows, columns = texels.shape
            value = bilinear(texels, a / length * columns - 0.5, b / width * rows - 0.5, wrap=False)
            out = np.where(face == k, value, out)
        return out

    def grey(self, pose: Array) -> Array:
        """Image (H, W) in grey levels, without noise and rounding."""
        n, o = self.samples, self.optics
        total = np.zeros(o.width * o.height)
        v, u = (c.ravel().astype(float) for c in np.indices((o.height, o.width)))
        for k in range(n * n):
            du, dv = (k % n + 0.5) / n - 0.5, (k // n + 0.5) / n - 0.5
            origin, ray = self.rays(pose, u + du, v + dv)
            depth, face, a, b = self.hits(origin, ray)
            veil, c = 255 * self.water.veil[1], self.water.attenuation[1]
            # The camera frame's axes have unit length and the optical part is 1.
            slant = depth * np.linalg.norm(ray, axis=0)
            path = {"beer": c * slant, "uwsim": (c * depth) ** 2}[self.water.law]
            total += (self.shade(face, a, b) - veil) * np.exp(-path) + veil
        return (total / n**2).reshape(o.height, o.width)


@pytest.fixture(scope="session")
def reference() -> Callable[..., Reference]:
    return Reference


@pytest.fixture(scope="session")
def tilted() -> Array:
    """A pose 1.27 m above the default box, off its middle, with all angles."""
    offset = np.array([0.06, -0.09, 0.04, 0.06, -0.05, 0.22])
    return start_pose(VISIBILITY, Target(), 1.27) + offset


@pytest.fixture(params=["currents", "visibility"])
def camera(request: pytest.FixtureRequest) -> Camera:
    optics = {"currents": CURRENTS, "visibility": VISIBILITY}[request.param]
    return Camera(optics, Water(), Target(), noise_seed=11)
