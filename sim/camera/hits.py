"""Where rays meet a body, and how bright it is there: sixteen rays at a time.

Rays are (x, y, 1) in the axes of the camera; a hit is a depth along the optical axis and an outward
normal in the axes of the body. Rounding is that of float32 alone, so every processor has the same.
"""

from typing import TYPE_CHECKING

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.camera import rows
from seamark.sim.camera.bodies import BOX, CYLINDER
from seamark.sim.camera.lighting import EVEN, Lighting, lamp_on
from seamark.sim.camera.sightings import NEAR_M, Body, Triple
from seamark.sim.numerics.simd import (
    f32x16,
    gather_pairs,
    maximum,
    minimum,
    select_greater,
    sqrt,
    to_f32,
    to_i32,
)

if TYPE_CHECKING:
    from seamark.sim.numerics.simd import F32x16

    Vectors = tuple[F32x16, F32x16, F32x16]
    Hits = tuple[F32x16, F32x16, F32x16, F32x16]  # depth, normal; FAR without a hit

Texels = NDArray[np.uint16]

FAR = 1e6  # [m] no hit


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def ray(body: Body, x: "F32x16", y: "F32x16") -> "Vectors":
    """Return rays in the axes of a body."""
    return (
        f32x16(body.ray_x[0]) * x + (f32x16(body.ray_x[1]) * y + f32x16(body.ray_x[2])),
        f32x16(body.ray_y[0]) * x + (f32x16(body.ray_y[1]) * y + f32x16(body.ray_y[2])),
        f32x16(body.ray_z[0]) * x + (f32x16(body.ray_z[1]) * y + f32x16(body.ray_z[2])),
    )


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def hit(kind: int, body: Body, d: "Vectors") -> "Hits":
    """Return where rays meet a body from outside."""
    if kind == BOX:
        return _hit_box(body, d)
    if kind == CYLINDER:
        return _hit_cylinder(body, d)
    return _hit_capsule(body, d)


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _hit_box(body: Body, d: "Vectors") -> "Hits":
    """A ray is inside between the last plane that it enters by and the first that it leaves by."""
    zero, one, far = f32x16(0.0), f32x16(1.0), f32x16(FAR)
    ox, oy, oz = body.camera[0], body.camera[1], body.camera[2]
    hx, hy, hz = body.half[0], body.half[1], body.half[2]
    ix, iy, iz = one / d[0], one / d[1], one / d[2]
    ax, bx = f32x16(-hx - ox) * ix, f32x16(hx - ox) * ix
    ay, by = f32x16(-hy - oy) * iy, f32x16(hy - oy) * iy
    az, bz = f32x16(-hz - oz) * iz, f32x16(hz - oz) * iz
    x, y, z = minimum(ax, bx), minimum(ay, by), minimum(az, bz)
    later = maximum(y, z)
    enter = maximum(x, later)
    leave = minimum(maximum(ax, bx), minimum(maximum(ay, by), maximum(az, bz)))
    depth = select_greater(leave, enter, enter, far)
    depth = select_greater(depth, f32x16(NEAR_M), depth, far)
    sx, sy, sz = f32x16(body.side[0]), f32x16(body.side[1]), f32x16(body.side[2])
    nx = select_greater(x, later, sx, zero)
    ny = select_greater(x, later, zero, select_greater(y, z, sy, zero))
    nz = select_greater(x, later, zero, select_greater(y, z, zero, sz))
    return depth, nx, ny, nz


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _hit_side(body: Body, d: "Vectors") -> "tuple[F32x16, F32x16, F32x16, F32x16]":
    """Return depth and place x at which rays enter an endless cylinder, and two terms of it.

    These are the discriminant, negative for those that miss it, and the square of the part of the
    ray across the axis. From the cross product: its terms have similar sizes, those of the usual
    form do not.
    """
    oy, oz, radius = body.camera[1], body.camera[2], body.half[1]
    square = maximum(d[1] * d[1] + d[2] * d[2], f32x16(1e-12))
    cross = f32x16(oy) * d[2] - f32x16(oz) * d[1]
    discriminant = f32x16(radius * radius) * square - cross * cross
    root = sqrt(maximum(discriminant, f32x16(0.0)))
    nearest = f32x16(oy) * d[1] + f32x16(oz) * d[2]
    depth = (f32x16(0.0) - nearest - root) / square
    return depth, f32x16(body.camera[0]) + depth * d[0], discriminant, square


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _hit_cylinder(body: Body, d: "Vectors") -> "Hits":
    zero, far, near = f32x16(0.0), f32x16(FAR), f32x16(NEAR_M)
    ox, oy, oz = body.camera[0], body.camera[1], body.camera[2]
    half, radius = body.half[0], body.half[1]
    depth, x, discriminant, _ = _hit_side(body, d)
    depth = select_greater(discriminant, zero, depth, far)
    outside = maximum(x, zero - x)
    depth = select_greater(outside, f32x16(half), far, depth)
    depth = select_greater(depth, near, depth, far)
    inverse = f32x16(np.float32(1.0) / radius)
    ny = (f32x16(oy) + depth * d[1]) * inverse
    nz = (f32x16(oz) + depth * d[2]) * inverse
    nx = zero
    if abs(ox) > half:  # the camera is beyond an end
        side = body.side[0]
        end = f32x16(side * half - ox) / d[0]
        y, z = f32x16(oy) + end * d[1], f32x16(oz) + end * d[2]
        end = select_greater(f32x16(radius * radius), y * y + z * z, end, far)
        end = select_greater(end, near, end, far)
        nx = select_greater(depth, end, f32x16(side), zero)
        ny = select_greater(depth, end, zero, ny)
        nz = select_greater(depth, end, zero, nz)
        depth = minimum(depth, end)
    return depth, nx, ny, nz


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _hit_capsule(body: Body, d: "Vectors") -> "Hits":
    """A ray that enters the endless cylinder beyond an end can only meet the ball there."""
    zero, far = f32x16(0.0), f32x16(FAR)
    ox, oy, oz = body.camera[0], body.camera[1], body.camera[2]
    half, radius = body.half[0], body.half[1]
    side, x, discriminant, square = _hit_side(body, d)
    end = minimum(maximum(x, f32x16(-half)), f32x16(half))
    from_end = f32x16(ox) - end
    length = square + d[0] * d[0]
    cx = f32x16(oy) * d[2] - f32x16(oz) * d[1]
    cy = f32x16(oz) * d[0] - from_end * d[2]
    cz = from_end * d[1] - f32x16(oy) * d[0]
    inside = f32x16(radius * radius) * length - (cx * cx + cy * cy + cz * cz)
    root = sqrt(maximum(inside, zero))
    nearest = from_end * d[0] + f32x16(oy) * d[1] + f32x16(oz) * d[2]
    ball = (zero - nearest - root) / length
    ball = select_greater(inside, zero, ball, far)
    beyond = maximum(x, zero - x)
    depth = select_greater(beyond, f32x16(half), ball, side)
    depth = select_greater(discriminant, zero, depth, far)
    depth = select_greater(depth, f32x16(NEAR_M), depth, far)
    inverse = f32x16(np.float32(1.0) / radius)
    nx = select_greater(beyond, f32x16(half), (from_end + depth * d[0]) * inverse, zero)
    return (
        depth,
        nx,
        (f32x16(oy) + depth * d[1]) * inverse,
        (f32x16(oz) + depth * d[2]) * inverse,
    )


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def mark(kind: int, body: Body, hits: "Hits") -> "F32x16":
    """Return what pixels are marked with: where it changes, an edge is seen."""
    _, nx, ny, nz = hits
    name = f32x16(body.mark)
    if kind == BOX:
        return name + (nx * nx + f32x16(2.0) * (ny * ny) + f32x16(3.0) * (nz * nz))
    if kind == CYLINDER:
        return name + nx * nx
    return name


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def tone(body: Body, d: "Vectors", hits: "Hits", texels: Texels, lighting: Lighting) -> "F32x16":
    """Return the radiance [grey] of a body where rays meet it."""
    depth, nx, ny, nz = hits
    depth = minimum(depth, f32x16(1e3))  # so that texture addresses of rays that miss are numbers
    sun = nx * f32x16(body.sun[0]) + ny * f32x16(body.sun[1]) + nz * f32x16(body.sun[2])
    light = (f32x16(EVEN) + sun) * f32x16(lighting.level)
    albedo = f32x16(body.albedo)
    lit = lighting.lamp > 0.0
    if lit or body.textured:
        px = f32x16(body.camera[0]) + depth * d[0]
        py = f32x16(body.camera[1]) + depth * d[1]
        pz = f32x16(body.camera[2]) + depth * d[2]
        if lit:
            to_lamp = (
                f32x16(body.lamp[0]) - px,
                f32x16(body.lamp[1]) - py,
                f32x16(body.lamp[2]) - pz,
            )
            beam = f32x16(body.beam[0]), f32x16(body.beam[1]), f32x16(body.beam[2])
            light = light + lamp_on(to_lamp, (nx, ny, nz), beam, lighting)
        if body.textured:
            albedo = _texel(body, nx, nz, (px, py, pz), texels)
    return albedo * light


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _by_axis(values: Triple, nx: "F32x16", nz: "F32x16") -> "F32x16":
    """Return the one of three numbers that belongs to the axis of the normals."""
    half = f32x16(0.5)
    other = select_greater(nz * nz, half, f32x16(values[2]), f32x16(values[1]))
    return select_greater(nx * nx, half, f32x16(values[0]), other)


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _texel(body: Body, nx: "F32x16", nz: "F32x16", place: "Vectors", texels: Texels) -> "F32x16":
    """Return the texture [grey] at places on the faces of a box."""
    zero, half, rim = f32x16(0.0), f32x16(0.5), f32x16(1.001)
    px, py, pz = place
    a = select_greater(nx * nx, half, py, px)
    b = select_greater(nz * nz, half, py, pz)
    columns, height = _by_axis(body.columns, nx, nz), _by_axis(body.rows, nx, nz)
    u = _by_axis(body.across, nx, nz) + _by_axis(body.across_slope, nx, nz) * a
    v = _by_axis(body.down, nx, nz) + _by_axis(body.down_slope, nx, nz) * b
    u = maximum(minimum(u, columns - rim), zero)
    v = maximum(minimum(v, height - rim), zero)
    iu, iv = to_i32(u), to_i32(v)
    offset = to_i32(_by_axis(body.offset, nx, nz))
    four = gather_pairs(texels, offset + (iv * to_i32(columns) + iu))
    return rows.bilinear(four, u - to_f32(iu), v - to_f32(iv))
