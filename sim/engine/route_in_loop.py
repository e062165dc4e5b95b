"""A route that a vehicle follows: how far it got, how far off it is, and what it is told."""

import math
from dataclasses import dataclass

import numpy as np

from seamark.sim.control.observation import ROUTE_NUMBERS, ROUTE_POINTS, STARTS
from seamark.sim.control.track.guide import Guide
from seamark.sim.control.track.navigation import Measured, to_body
from seamark.sim.control.track.pipe_guide import PipeGuide
from seamark.sim.engine.pipe_in_loop import PipeReport
from seamark.sim.metrics.following import REACH_M, REJOIN_M, WINDOW_M
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.libm import atan2, sincos
from seamark.sim.numerics.polyline import nearest, starts_of
from seamark.sim.physics.pipe import Pipe
from seamark.sim.recording.telemetry import INDEX, ROUTE_INDEX, ROUTE_WIDTH, WIDTH
from seamark.sim.sensors.usbl import Noise, Usbl

_ROUTE = slice(0, 3 * ROUTE_POINTS)
_FIX = slice(_ROUTE.stop, _ROUTE.stop + 4)  # north, east, age, standard deviation
_PIPE = slice(_FIX.stop, _FIX.stop + 2)  # offset, angle
GUIDE_M = 1.0  # E: how far ahead of the nearest point the position error points
NO_FIX = -1.0  # age of a fix before the first one
_POINT, _ALONG = ROUTE_INDEX["route_x"] - WIDTH, ROUTE_INDEX["route_along"] - WIDTH
_ERROR = slice(INDEX["error_x"], INDEX["error_z"] + 1)
_SEEN_ERROR = slice(STARTS["error"], STARTS["error"] + 3)
_SURGE, _YAW = STARTS["velocity"], STARTS["attitude"] + 2
_FIXED, _BOAT = ROUTE_INDEX["fix_x"] - WIDTH, ROUTE_INDEX["boat_x"] - WIDTH


@dataclass(frozen=True, slots=True, kw_only=True)
class Course:
    """What is to be followed in a level, and what the vehicle is told of its position."""

    route_m: Array  # (ROUTE_POINTS, 3) NED
    told_m: Array  # likewise, what the vehicle is told of it
    pipe: Pipe | None = None  # below the route, which has to be seen then
    boat_m: Array  # (3,) NED, the acoustic transceiver
    start_error_m: tuple[float, float]  # north, east, of where the vehicle is said to start
    most_start_error_m: float  # that this may be
    noise: Noise
    rng: np.random.Generator  # of the noise


class RouteInLoop:
    """The route of a level, in its rows and in the observation."""

    def __init__(
        self,
        course: Course,
        observation: Array,
        first: int,
        start_m: Array,
        *,
        steps: int,
        step_s: float,
        pipe: PipeReport | None = None,
    ) -> None:
        """Set up a level of `steps` control steps, with a pipe to look for or without.

        The part of the observation that is about the route begins at index `first`; `start_m` is
        where the vehicle starts, (3,) NED.
        """
        self._points, self._starts = course.route_m, starts_of(course.route_m)
        self._usbl = Usbl(course.rng, course.noise, course.boat_m, steps=steps, step_s=step_s)
        seen = observation[first : first + ROUTE_NUMBERS]
        self._boat, self._seen, self._observation = course.boat_m, seen, observation
        self._origin = start_m[:2] + course.start_error_m  # of all positions that are told
        self._step_s = step_s
        self._along = 0.0
        told = course.told_m.copy()
        told[:, :2] -= self._origin
        seen[_ROUTE] = told.ravel()
        seen[_FIX] = 0.0, 0.0, NO_FIX, 0.0
        self._pipe = pipe
        self._guide: Guide | PipeGuide = Guide(told, GUIDE_M, course.most_start_error_m)
        if pipe is not None:
            north, east = (told[1, :2] - told[0, :2]).tolist()
            pipe.begin(atan2(east, north))
            self._guide = PipeGuide(told, GUIDE_M)

    def measure(self, step: int, pose: Array, row: Array) -> None:
        """Fill the columns of a row, and the observation."""
        columns = row[WIDTH : WIDTH + ROUTE_WIDTH]
        self._follow(pose[:3], columns)
        self._usbl.step(step, pose[:3])
        self._report(step, columns)
        columns[_BOAT : _BOAT + 3] = self._boat
        row[_ERROR] = self._observation[_SEEN_ERROR] = self._way(step)
        if self._pipe is None:
            self._observation[STARTS["target_visible"]] = 1.0
            self._observation[STARTS["target_age"]] = 0.0

    def _follow(self, position: Array, columns: Array) -> None:
        length = float(self._starts[-1])
        last = min(self._along + WINDOW_M, length)
        place = columns[_POINT : _POINT + 6]
        along, off = nearest(self._points, self._starts, position, self._along, last, place)
        if off > REACH_M:
            last = min(self._along + REJOIN_M, length)
            along, off = nearest(self._points, self._starts, position, self._along, last, place)
        if off <= REACH_M:
            self._along = along
        x, y, z = (position - place[:3]).tolist()
        ahead, side = place[3:5].tolist()
        level = math.sqrt(ahead * ahead + side * side)
        starboard = (ahead * y - side * x) / level if level > 0.0 else 0.0
        columns[_ALONG : _ALONG + 5] = self._along, length, off, starboard, z

    def _way(self, step: int) -> tuple[float, float, float]:
        """Return how far to move to the point to steer for, by what the vehicle knows, body."""
        seen = self._observation
        fix_north, fix_east, age, sigma = self._seen[_FIX].tolist()
        now = Measured(
            t=seen.item(STARTS["t"]),
            dt=self._step_s,
            speeds=(seen.item(_SURGE), seen.item(_SURGE + 1)),
            depth=seen.item(STARTS["depth"]),
            yaw=sincos(seen.item(_YAW)),
            fix=(fix_north, fix_east),
            fix_age=age,
            fix_sigma=sigma,
            pipe=(0.0, 0.0),
        )
        if self._pipe is not None:
            beside = self._pipe.beside(step, now, seen)
            self._seen[_PIPE], now = beside, now._replace(pipe=beside)
        self._guide.update(now)
        north, east, down, _length = self._guide.to_aim()
        return *to_body(north, east, now.yaw), down

    def _report(self, step: int, columns: Array) -> None:
        fix, told = self._usbl.last, columns[_FIXED:_BOAT]
        if fix is None:
            told[:] = math.nan
            return
        age = (step - fix.at_step) * self._step_s
        told[:3] = fix.position_m
        told[3:] = age, fix.sigma_m, fix.range_m, fix.bearing_rad, fix.elevation_rad
        north, east = (fix.position_m[:2] - self._origin).tolist()
        self._seen[_FIX] = north, east, age, fix.sigma_m
