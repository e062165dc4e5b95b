"""What lies on the bottom: the surface of each kind of thing, seen from above.

A thing has axes of its own: x along its length, y along its width, origin in the middle of its plan
rectangle. The surface of a kind is a function of x and y [m]: distance inside its outline, height
above the bottom, and albedo. Only + - * / sqrt and the simulator's own functions are used, so that
every processor gives the same bytes. Sizes and colours are our estimates (E) of common things.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from seamark.sim.camera.seabed import TEXEL_M, value_noise
from seamark.sim.numerics.libm import PI, atan2, cos

BOX, AMPHORA, PIPE, PANEL, CONNECTOR, ANODE, ARUCO, APRILTAG = range(8)
ROCK, SHELL, BOTTLE, CAN, PLANK, SLAB, STARFISH, FALSE_MARKER = range(8, 16)

Array = NDArray[np.float64]
Colour = tuple[float, float, float]  # albedo in red, green, blue
_SUNK = 0.5  # of the largest radius: a body of revolution lies that deep in the bottom
_BEVEL_M = 0.012
_LETTER = 0.075  # of a box's width: half the width of a stroke
_PAINT = 0.80  # albedo of letters and of a marker's white
_INK = 0.05  # albedo of a marker's black


class Shape(NamedTuple):
    """One thing, as the kernels read it."""

    kind: int
    length: float  # [m] along x
    width: float  # [m] along y
    height: float  # [m]
    form: Array  # (8,) from 0 to 1: what varies within a kind
    base: Colour
    second: Colour
    strokes: Array  # (n, 4) [m] line segments of its lettering
    bits: NDArray[np.uint8]  # (n, n) of a marker, 1 white; with its black border
    seed: int  # of its stains


class Sample(NamedTuple):
    """The surface at one point."""

    inside: float  # [m] distance from the outline; negative outside
    height: float  # [m] above the bottom
    colour: Colour


@njit(cache=True, nogil=True, error_model="numpy")
def stains(x: float, y: float, cells: int, seed: int) -> float:
    """Return value noise in [-1, 1] of so many cells per metre."""
    return float(value_noise(x - np.floor(x), y - np.floor(y), cells, seed))


@njit(cache=True, nogil=True, error_model="numpy")
def _blend(first: Colour, second: Colour, share: float) -> Colour:
    return (
        first[0] + share * (second[0] - first[0]),
        first[1] + share * (second[1] - first[1]),
        first[2] + share * (second[2] - first[2]),
    )


@njit(cache=True, nogil=True, error_model="numpy")
def _toned(colour: Colour, factor: float) -> Colour:
    return (colour[0] * factor, colour[1] * factor, colour[2] * factor)


@njit(cache=True, nogil=True, error_model="numpy")
def _covers(distance: float) -> float:
    """Return how much of a texel is covered, whose centre is so far [m] inside an edge."""
    return min(max(distance / TEXEL_M + 0.5, 0.0), 1.0)


@njit(cache=True, nogil=True, error_model="numpy")
def _grey(albedo: float) -> Colour:
    return (albedo, albedo, albedo)


@njit(cache=True, nogil=True, error_model="numpy")
def _from_segment(x: float, y: float, x0: float, y0: float, x1: float, y1: float) -> float:
    """Return the distance of a point from a line segment."""
    dx, dy = x1 - x0, y1 - y0
    along = ((x - x0) * dx + (y - y0) * dy) / max(dx * dx + dy * dy, 1e-12)
    along = min(max(along, 0.0), 1.0)
    ex, ey = x - x0 - along * dx, y - y0 - along * dy
    return float(np.sqrt(ex * ex + ey * ey))


@njit(cache=True, nogil=True, error_model="numpy")
def _in_rectangle(x: float, y: float, s: Shape) -> float:
    return min(0.5 * s.length - abs(x), 0.5 * s.width - abs(y))


@njit(cache=True, nogil=True, error_model="numpy")
def _revolved(y: float, radius: float, largest: float) -> tuple[float, float]:
    """Return distance inside and height of a lying body of revolution, where it is so wide."""
    inside = radius - abs(y)
    height = _SUNK * largest + np.sqrt(max(radius * radius - y * y, 0.0))
    return inside, height


@njit(cache=True, nogil=True, error_model="numpy")
def _slab(x: float, y: float, s: Shape) -> Sample:
    """A dark body with bevelled edges; a box is one with lettering, bolts and a worn rim."""
    inside = _in_rectangle(x, y, s)
    height = s.height * min(1.0, 0.6 + 0.4 * inside / _BEVEL_M)
    colour = _toned(s.base, 1.0 + 0.25 * stains(x, y, 23, s.seed))
    if s.kind == BOX:
        rim = _covers(0.004 - abs(inside - 0.008))
        colour = _blend(colour, _grey(0.16), rim)
        nearest = 1.0
        for k in range(s.strokes.shape[0]):
            x0, y0, x1, y1 = s.strokes[k]
            nearest = min(nearest, _from_segment(x, y, x0, y0, x1, y1))
        colour = _blend(colour, s.second, _covers(_LETTER * s.width - nearest))
        bolt_x, bolt_y = 0.5 * s.length - 0.022 - abs(x), 0.5 * s.width - 0.022 - abs(y)
        bolt = np.sqrt(bolt_x * bolt_x + bolt_y * bolt_y)
        colour = _blend(colour, _grey(0.34), _covers(0.008 - bolt))
    return Sample(inside, height, colour)


@njit(cache=True, nogil=True, error_model="numpy")
def _amphora(x: float, y: float, s: Shape) -> Sample:
    """A jar: foot, belly, shoulder, neck and lip, with two handles."""
    t = x / s.length + 0.5
    half = 0.5 * s.width
    belly = 0.78 * half  # the handles reach as far as the belly or farther
    neck_at, neck = 0.68 + 0.12 * s.form[0], 0.26 + 0.16 * s.form[1]
    peak = 0.50 + 0.22 * s.form[2]
    u = min(max(t / neck_at, 0.0), 1.0)
    if u < peak:
        w = u / peak
        share = max(w * (2.0 - w), 0.14)
    else:
        w = (1.0 - u) / (1.0 - peak)
        share = neck + (1.0 - neck) * w * (2.0 - w)
    if t > 0.955:
        share = neck * 1.4
    radius = belly * share
    if t < 0.0 or t > 1.0:
        radius = 0.0
    inside, height = _revolved(y, radius, belly)
    inside = min(inside, s.length * min(t, 1.0 - t) + 0.5 * TEXEL_M)
    shoulder, mouth = (neck_at - 0.10 - 0.5) * s.length, (0.93 - 0.5) * s.length
    bow = (0.5 * (neck_at + 0.93) - 0.5 + 0.05) * s.length
    thick = 0.010 + 0.008 * s.form[3]
    out = half - thick
    handle = thick - min(
        _from_segment(x, abs(y), shoulder, 0.8 * belly, bow, out),
        _from_segment(x, abs(y), bow, out, mouth, belly * neck),
    )
    colour = _toned(s.base, 1.0 + 0.22 * stains(x, y, 17, s.seed) + 0.1 * stains(x, y, 71, s.seed))
    ring = 0.5 + 0.5 * cos(2.0 * PI * (26.0 + 10.0 * s.form[4]) * t)
    colour = _toned(colour, 1.0 - 0.10 * ring)
    if handle > inside:
        return Sample(handle, _SUNK * belly + 0.6 * thick, _toned(colour, 0.85))
    return Sample(inside, height, colour)


@njit(cache=True, nogil=True, error_model="numpy")
def _pipe(x: float, y: float, s: Shape) -> Sample:
    """A piece of pipe with a flange at one end or both, and perhaps a band of another colour."""
    half = 0.5 * s.width
    ends = 0.5 * s.length
    flange = ends - (x if s.form[0] < 0.5 else abs(x)) < 0.022
    radius = half if flange else 0.74 * half
    inside, height = _revolved(y, radius, half)
    inside = min(inside, ends - abs(x))
    colour = _toned(s.base, 1.0 + 0.18 * stains(x, y, 29, s.seed))
    rust = stains(x, y, 12, s.seed + 1) + 0.6 * stains(x, y, 43, s.seed + 2)
    colour = _blend(colour, (0.30, 0.15, 0.07), _covers(0.02 * (rust - 1.2 + 1.6 * s.form[1])))
    band = abs(x - (s.form[2] - 0.5) * 0.7 * s.length)
    if s.form[3] > 0.5:
        colour = _blend(colour, s.second, _covers(0.03 - band))
    if not flange and ends - abs(x) < 0.035:
        colour = _toned(colour, 0.7)
    return Sample(inside, height, colour)


@njit(cache=True, nogil=True, error_model="numpy")
def _panel(x: float, y: float, s: Shape) -> Sample:
    """A plate with a frame and two or three T-handles, each at an angle of its own."""
    inside = _in_rectangle(x, y, s)
    height = s.height * min(1.0, 0.5 + inside / _BEVEL_M)
    colour = _toned(s.base, 1.0 + 0.10 * stains(x, y, 11, s.seed))
    colour = _blend(colour, _toned(s.base, 0.45), _covers(0.006 - abs(inside - 0.022)))
    valves = 2 if s.form[0] < 0.5 else 3
    reach = min(0.30 * s.width, 0.40 * s.length / valves)
    for k in range(valves):
        cx = ((k + 0.5) / valves - 0.5) * 0.86 * s.length
        angle = PI * s.form[1 + k]
        dx, dy = reach * cos(angle), reach * cos(angle - 0.5 * PI)
        dish = 1.15 * reach - np.sqrt((x - cx) * (x - cx) + y * y)
        colour = _blend(colour, _toned(s.base, 0.30), _covers(dish))
        bar = 0.20 * reach - _from_segment(x, y, cx - dx, -dy, cx + dx, dy)
        if bar > -TEXEL_M:
            colour = _blend(colour, s.second, _covers(bar))
            height = max(height, s.height + 0.05 * _covers(bar))
    return Sample(inside, height, colour)


@njit(cache=True, nogil=True, error_model="numpy")
def _connector(x: float, y: float, s: Shape) -> Sample:
    """An underwater plug: pins' sleeve, ribbed grip, collar, boot and the end of its cable."""
    t = x / s.length + 0.5
    half = 0.5 * s.width
    colour = s.base
    if t < 0.14:
        share = 0.52
        colour = _grey(0.42)
    elif t < 0.48:
        share = 0.84
        rib = (t - 0.14) * (26.0 + 12.0 * s.form[0])
        colour = _toned(s.base, 0.55 if rib - np.floor(rib) < 0.4 else 1.0)
    elif t < 0.62:
        share = 1.0
        colour = s.second
    elif t < 0.80:
        share = 0.78 - 1.7 * (t - 0.62)
        colour = _toned(s.base, 0.8)
    else:
        share = 0.26 + 0.06 * s.form[1]
        colour = _grey(0.07)
    radius = half * share
    inside, height = _revolved(y, radius, half)
    inside = min(inside, 0.5 * s.length - abs(x))
    return Sample(inside, height, _toned(colour, 1.0 + 0.10 * stains(x, y, 31, s.seed)))


@njit(cache=True, nogil=True, error_model="numpy")
def _anode(x: float, y: float, s: Shape) -> Sample:
    """A sacrificial anode: a bar of zinc, cast on a flat steel strap that sticks out."""
    bar_half = (0.33 + 0.06 * s.form[0]) * s.length
    across = 0.5 * s.width * (1.0 - 0.12 * abs(x) / bar_half)
    bar = min(bar_half - abs(x), across - abs(y))
    strap = min(0.5 * s.length - abs(x), (0.16 + 0.08 * s.form[1]) * s.width - abs(y))
    hole = np.sqrt((abs(x) - 0.5 * s.length + 0.018) ** 2 + y * y) - 0.007
    corroded = stains(x, y, 47, s.seed) + 0.7 * stains(x, y, 111, s.seed + 1)
    if bar > -0.5 * TEXEL_M:
        colour = _toned(s.base, 1.0 + 0.22 * corroded)
        return Sample(bar, s.height * min(1.0, 0.7 + 0.3 * bar / 0.02), colour)
    colour = _blend(_grey(0.20), (0.26, 0.14, 0.08), 0.5 + 0.4 * corroded)
    return Sample(min(strap, hole), 0.012, colour)


@njit(cache=True, nogil=True, error_model="numpy")
def _marker(x: float, y: float, s: Shape) -> Sample:
    """A plate with a square code inside a white margin of one module."""
    inside = _in_rectangle(x, y, s)
    n = s.bits.shape[0]
    module = s.length / (n + 2)
    white = 0
    for j in range(3):
        for i in range(3):
            u = (x + (i - 1) * TEXEL_M / 3.0) / module + 0.5 * n
            v = (y + (j - 1) * TEXEL_M / 3.0) / module + 0.5 * n
            if u < 0.0 or v < 0.0 or u >= n or v >= n or s.bits[int(v), int(u)]:
                white += 1
    tone = _INK + (_PAINT - _INK) * white / 9.0
    return Sample(inside, s.height, _grey(tone * (1.0 + 0.05 * stains(x, y, 19, s.seed))))


@njit(cache=True, nogil=True, error_model="numpy")
def _rock(x: float, y: float, s: Shape) -> Sample:
    """A dome with a rough outline."""
    u, v = 2.0 * x / s.length, 2.0 * y / s.width
    rough = 1.0 + 0.20 * stains(x, y, 7, s.seed) + 0.10 * stains(x, y, 19, s.seed + 1)
    q = 1.12 * rough * np.sqrt(u * u + v * v)
    facets = stains(x, y, 13, s.seed + 2) + 0.6 * stains(x, y, 37, s.seed + 3)
    height = s.height * np.sqrt(max(1.0 - q * q, 0.0)) * (0.9 + 0.18 * facets)
    tone = 1.0 + 0.20 * facets + 0.14 * stains(x, y, 97, s.seed + 4)
    return Sample(0.5 * s.width * (1.0 - q), max(height, 0.0), _toned(s.base, tone))


@njit(cache=True, nogil=True, error_model="numpy")
def _shell(x: float, y: float, s: Shape) -> Sample:
    """A fan with ribs from its hinge."""
    px = x + 0.5 * s.length
    radius = np.sqrt(px * px + y * y)
    angle = atan2(y, px)
    spread = 0.5 * s.width / (0.8 * s.length)
    reach = s.length * (1.0 - 0.35 * angle * angle)
    inside = min(reach - radius, (spread - abs(angle)) * radius)
    ribs = 0.5 + 0.5 * cos(angle * (26.0 + 14.0 * s.form[0]))
    rings = 0.5 + 0.5 * cos(radius / s.length * 22.0)
    along = radius / s.length
    height = s.height * 4.0 * along * (1.05 - along) * (0.85 + 0.15 * ribs)
    return Sample(inside, max(height, 0.0), _toned(s.base, 0.72 + 0.22 * ribs + 0.10 * rings))


@njit(cache=True, nogil=True, error_model="numpy")
def _bottle(x: float, y: float, s: Shape) -> Sample:
    """A bottle with a label."""
    t = x / s.length + 0.5
    half = 0.5 * s.width
    neck_at = 0.60 + 0.10 * s.form[0]
    if t < neck_at:
        share = 1.0
    elif t < neck_at + 0.14:
        share = 1.0 - 0.62 * (t - neck_at) / 0.14
    else:
        share = 0.38
    inside, height = _revolved(y, half * share, half)
    inside = min(inside, 0.5 * s.length - abs(x))
    colour = s.base
    if 0.18 < t < neck_at - 0.08 and s.form[1] > 0.4:
        colour = _toned(s.second, 1.0 + 0.3 * stains(x, y, 57, s.seed))
    if t > 0.94:
        colour = s.second
    glint = _covers(0.10 * s.width - abs(y + 0.22 * s.width))
    return Sample(inside, height, _blend(colour, _grey(0.75), 0.35 * glint))


@njit(cache=True, nogil=True, error_model="numpy")
def _can(x: float, y: float, s: Shape) -> Sample:
    """A tin with metal ends and a printed body."""
    half = 0.5 * s.width
    ends = 0.5 * s.length - abs(x)
    inside, height = _revolved(y, half if ends > 0.008 else 0.9 * half, half)
    inside = min(inside, ends)
    if ends < 0.010:
        return Sample(inside, height, _grey(0.55))
    wave = stains(0.4 * x, y, 61, s.seed) + 0.5 * stains(x, y, 23, s.seed + 1)
    colour = _blend(s.base, s.second, _covers(0.01 * (wave - 0.2 + 0.4 * s.form[0])))
    return Sample(inside, height, colour)


@njit(cache=True, nogil=True, error_model="numpy")
def _plank(x: float, y: float, s: Shape) -> Sample:
    """A board with grain along its length and ends that are broken."""
    inside = _in_rectangle(x, y, s)
    broken = 0.5 * s.length - abs(x) - 0.03 * (1.0 + stains(0.0, y, 61, s.seed + 3))
    inside = min(inside, broken)
    grain = stains(0.06 * x, y, 160, s.seed) + 0.6 * stains(0.1 * x, y, 60, s.seed + 1)
    knots = max(stains(0.5 * x, y, 9, s.seed + 2) - 0.55, 0.0)
    return Sample(inside, s.height, _toned(s.base, 1.0 + 0.20 * grain - 1.1 * knots))


@njit(cache=True, nogil=True, error_model="numpy")
def _starfish(x: float, y: float, s: Shape) -> Sample:
    """Five arms."""
    radius = np.sqrt(x * x + y * y)
    half = 0.5 * s.length
    arms = abs(cos(2.5 * atan2(y, x)))
    reach = half * (0.30 + 0.70 * arms * arms * (0.55 + 0.45 * arms))
    inside = 0.5 * (reach - radius)
    height = s.height * (1.0 - 0.8 * radius / half)
    dots = _covers(0.01 * (stains(x, y, 130, s.seed) - 0.55))
    colour = _blend(s.base, s.second, 0.6 * dots)
    return Sample(inside, max(height, 0.002), _toned(colour, 0.8 + 0.4 * arms))


@njit(cache=True, nogil=True, error_model="numpy")
def surface(x: float, y: float, s: Shape) -> Sample:  # noqa: C901, PLR0911  (one line per kind)
    """Return the surface of a thing at a point in its axes [m]."""
    if s.kind in (BOX, SLAB):
        return _slab(x, y, s)
    if s.kind == AMPHORA:
        return _amphora(x, y, s)
    if s.kind == PIPE:
        return _pipe(x, y, s)
    if s.kind == PANEL:
        return _panel(x, y, s)
    if s.kind == CONNECTOR:
        return _connector(x, y, s)
    if s.kind == ANODE:
        return _anode(x, y, s)
    if s.kind == ROCK:
        return _rock(x, y, s)
    if s.kind == SHELL:
        return _shell(x, y, s)
    if s.kind == BOTTLE:
        return _bottle(x, y, s)
    if s.kind == CAN:
        return _can(x, y, s)
    if s.kind == PLANK:
        return _plank(x, y, s)
    if s.kind == STARFISH:
        return _starfish(x, y, s)
    return _marker(x, y, s)
