"""The routes of track-v1: drawn for each level, all of one length, from the place of the start.

What a program saw in one level does not help it in the next.
"""

import math
from collections.abc import Callable

import numpy as np

from seamark.sim.control.observation import PIPE, ROUTE_POINTS
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.libm import PI, sincos
from seamark.sim.numerics.polyline import starts_of
from seamark.sim.physics.pipe import Pipe, pipe_along
from seamark.sim.settings.route import HELIX, LEMNISCATE, WAYPOINTS

LEGS = 5  # of the waypoints
LEAST_TURN_RAD, MOST_TURN_RAD = 0.6, 2.0  # E: from one leg to the next, to either side
DEPTHS = 0.06  # E: greatest rise or fall of a corner from the start, as a share of the length
LEAST_RADIUS, MOST_RADIUS = 0.1, 0.15  # of the helix, as a share of the length of the route; E
RISE = 0.08  # E: of the whole helix, as a share of the length
TILT_RAD = 0.25  # E: greatest tilt of the lemniscate
BENDS = 4  # of a pipe
LEAST_BEND_RAD, MOST_BEND_RAD = 0.35, 0.9  # E: of each, to either side; so it cannot cross itself
BEND_RADIUS = 0.1  # E: as a share of the length; real ones are wider, so nothing is easier here
BEYOND_M = 4.0  # E: how far the pipe goes on straight at both ends of the route
BARE_M = 4.0  # E: at the beginning of the route
SHORTEST_M, LONGEST_M = 1.0, 2.5  # E: stretches under sand
# E: albedo in red, green and blue of black polyethylene, bitumen and overgrown concrete
COATS = ((0.09, 0.09, 0.10), (0.17, 0.12, 0.08), (0.24, 0.25, 0.22))
MOST_COVERED = 6  # stretches for which numbers are drawn
_FINE = 16  # points between two of a smooth route, to measure its length by


def draw_route(kind: str, length_m: float, start_m: Array, random: np.random.Generator) -> Array:
    """Return a route of this length from a point (3,) NED on, (ROUTE_POINTS, 3) NED [m].

    Every kind takes as many random numbers from the stream.
    """
    shares = random.random(1 + 3 * LEGS).tolist()
    shape = _SHAPES[kind](shares)
    shape -= shape[0]
    scale = length_m / float(starts_of(shape)[-1])
    route: Array = start_m + scale * _turned(shape, 2.0 * PI * shares[0])
    return route


def _waypoints(shares: list[float]) -> Array:
    """Return straight legs of different length, each of which turns to either side."""
    lengths = [0.6 + 0.8 * share for share in shares[1 : 1 + LEGS]]
    corners, heading = [np.zeros(3)], 0.0
    for leg, length in enumerate(lengths):
        turn, depth = shares[1 + LEGS + leg], shares[1 + 2 * LEGS + leg]
        side = 2.0 * turn - 1.0
        size = LEAST_TURN_RAD + (MOST_TURN_RAD - LEAST_TURN_RAD) * abs(side)
        heading += math.copysign(size, side) if leg else 0.0
        sine, cosine = sincos(heading)
        corner = corners[-1] + length * np.array([cosine, sine, 0.0])
        corner[2] = DEPTHS * sum(lengths) * (2.0 * depth - 1.0)
        corners.append(corner)
    return _resampled(np.array(corners))


def _resampled(corners: Array) -> Array:
    """Return ROUTE_POINTS points on straight legs, which include the corners."""
    lengths = np.diff(starts_of(corners)).tolist()
    pieces = ROUTE_POINTS - 1
    counts = [max(1, round(pieces * length / sum(lengths))) for length in lengths]
    counts[counts.index(max(counts))] += pieces - sum(counts)
    points = [corners[0]]
    for begin, end, count in zip(corners, corners[1:], counts, strict=False):
        points += [begin + (end - begin) * (i / count) for i in range(1, count + 1)]
    return np.array(points)


def _helix(shares: list[float]) -> Array:
    """Return a helix of length 1 that rises or falls, and turns to either side."""
    radius = LEAST_RADIUS + (MOST_RADIUS - LEAST_RADIUS) * shares[1]
    turns = math.sqrt(1.0 - RISE * RISE) / (2.0 * PI * radius)
    side, way = (1.0 if share < 0.5 else -1.0 for share in shares[2:4])
    angles = [2.0 * PI * turns * i / (ROUTE_POINTS - 1) for i in range(ROUTE_POINTS)]
    points = []
    for i, angle in enumerate(angles):
        sine, cosine = sincos(angle)
        rise = way * RISE * i / (ROUTE_POINTS - 1)
        points.append((radius * sine, side * radius * (1.0 - cosine), rise))
    return np.array(points)


def _lemniscate(shares: list[float]) -> Array:
    """Return a figure of eight (Gerono's), once around, that begins at its end and is tilted."""
    width = 0.5 + 0.3 * shares[1]
    side = 1.0 if shares[2] < 0.5 else -1.0
    tilt = TILT_RAD * (2.0 * shares[3] - 1.0)
    count = _FINE * (ROUTE_POINTS - 1)
    fine = np.empty((count + 1, 3))
    for i in range(count + 1):
        sine, cosine = sincos(0.5 * PI + 2.0 * PI * i / count)
        fine[i] = sine, side * width * sine * cosine, tilt * sine
    starts = starts_of(fine)
    wanted = [float(starts[-1]) * i / (ROUTE_POINTS - 1) for i in range(ROUTE_POINTS)]
    picked = [int(np.searchsorted(starts, along)) for along in wanted]
    picked[-1] = count
    return fine[picked]


def _bends(shares: list[float]) -> Array:
    """Return a level route of length 1, straight but for a few bends to either side."""
    lengths = [0.6 + 0.8 * share for share in shares[1 : 1 + LEGS]]
    bends, reached = [], 0.0
    for length, share in zip(lengths[:BENDS], shares[1 + LEGS :], strict=False):
        reached += length / sum(lengths)
        side = 2.0 * share - 1.0
        size = LEAST_BEND_RAD + (MOST_BEND_RAD - LEAST_BEND_RAD) * abs(side)
        arc = BEND_RADIUS * size
        bends.append((reached - 0.5 * arc, arc, math.copysign(size, side)))
    count = _FINE * (ROUTE_POINTS - 1)
    fine = np.zeros((count + 1, 3))
    for i in range(count):
        along = (i + 0.5) / count
        heading = math.fsum(
            turn * min(max((along - start) / arc, 0.0), 1.0) for start, arc, turn in bends
        )
        sine, cosine = sincos(heading)
        fine[i + 1] = fine[i] + np.array([cosine, sine, 0.0]) / count
    return fine[::_FINE]


def lay_pipe(
    route: Array, seabed_m: float, radius_m: float, covered: int, random: np.random.Generator
) -> Pipe:
    """Return the pipe below a route, (k, 3) NED [m], with so many stretches under sand."""
    shares = random.random(2 + 2 * MOST_COVERED).tolist()
    first, last = route[1, :2] - route[0, :2], route[-1, :2] - route[-2, :2]
    sizes = [math.sqrt(float(step @ step)) for step in (first, last)]
    before = route[0, :2] - BEYOND_M / sizes[0] * first
    after = route[-1, :2] + BEYOND_M / sizes[1] * last
    bare = pipe_along(
        np.vstack([before, route[:, :2], after]),
        *(seabed_m, radius_m),
        seed=int(shares[0] * 2**24),
    )
    room = float(starts_of(route)[-1]) - BARE_M
    stretches = np.empty((covered, 2))
    for i, (place, size) in enumerate(zip(shares[2::2], shares[3::2], strict=True)):
        if i < covered:
            length = min(SHORTEST_M + (LONGEST_M - SHORTEST_M) * size, room / covered)
            start = BEYOND_M + BARE_M + i * room / covered
            start += place * (room / covered - length)
            stretches[i] = start, start + length
    coat = np.array(COATS[int(len(COATS) * shares[1])])
    return bare._replace(covered_m=stretches, coat=coat)


def _turned(points: Array, angle: float) -> Array:
    """Return points (k, 3) turned about the vertical."""
    sine, cosine = sincos(angle)
    out = points.copy()
    out[:, 0] = cosine * points[:, 0] - sine * points[:, 1]
    out[:, 1] = sine * points[:, 0] + cosine * points[:, 1]
    return out


_SHAPES: dict[str, Callable[[list[float]], Array]] = {
    WAYPOINTS: _waypoints,
    HELIX: _helix,
    LEMNISCATE: _lemniscate,
    PIPE: _bends,
}
