"""A dock that a vehicle enters: where it is against it, and what it is told of it."""

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from seamark.sim.control.observation import DOCK_NUMBERS
from seamark.sim.engine.search_in_loop import SearchInLoop
from seamark.sim.multibody.assembly import Mounting
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.libm import PI, sincos
from seamark.sim.recording.telemetry import DOCK_INDEX, DOCK_WIDTH, INDEX, WIDTH
from seamark.sim.sensors.usbl import Noise, Usbl

NO_FIX = -1.0  # age of an answer before the first one


def _column(name: str) -> int:
    return DOCK_INDEX[name] - WIDTH


_SEAT, _OFF = _column("dock_x"), _column("dock_ahead")
_DEPTH, _FIX, _LIGHT = _column("dock_depth"), _column("dock_fix_x"), _column("light_x")
_SEARCH = _column("searching")
_FOUND = slice(_SEARCH + 2, _SEARCH + 11)  # corners and confidence of an answer
_TARGET = slice(INDEX["target_x"], INDEX["target_y"] + 1)
_HEADING, _SEEN_LIGHT, _VISIBLE = 5, slice(6, 8), 8


@dataclass(frozen=True, slots=True, kw_only=True)
class Light:
    """How well the lamps beside the marker are seen."""

    sigma_px: float
    most_depths: float  # optical depth beyond which they are lost in the scattered light
    attenuation_1_m: float
    centre_px: tuple[float, float]  # of the image
    at_m: Array  # (3,) NED, the middle of the lamps


@dataclass(frozen=True, slots=True, kw_only=True)
class Dock:
    """What is to be entered in a level, and what the vehicle is told of it."""

    things: tuple[Mounting, ...]
    top_m: float  # least depth of any part of it
    mouth_m: float  # depth of the mouth
    seat_m: Array  # (3,) NED of the vehicle's origin when it is docked
    heading_rad: float  # of the vehicle likewise
    keel_m: float  # of the vehicle, below its origin
    noise: Noise  # of the acoustic answers
    least_range_m: float  # nearer than this there are none
    light: Light
    fixes: np.random.Generator  # the noise of the answers
    pixels: np.random.Generator  # and that of the lamps


class DockInLoop:
    """The dock of a level, in its rows and in the observation."""

    def __init__(  # what it reads, and the times of a level
        self,
        dock: Dock,
        search: SearchInLoop,
        observation: Array,
        first: int,
        *,
        late: int,
        steps: int,
        step_s: float,
    ) -> None:
        """Set up a level of `steps` control steps.

        The part of the observation that is about the dock begins at index `first`; images are
        `late` control steps late.
        """
        self._dock, self._search, self._step_s = dock, search, step_s
        self._seen = observation[first : first + DOCK_NUMBERS]
        # By symmetry: a transceiver at the dock that measures the vehicle has the same errors.
        self._usbl = Usbl(dock.fixes, dock.noise, dock.seat_m, steps=steps, step_s=step_s)
        self._noise = dock.light.sigma_px * dock.pixels.standard_normal((steps + 1, 2))
        self._positions = np.zeros((steps + 1, 3))
        self._lights: deque[Array | None] = deque(maxlen=late + 1)
        self._turn = sincos(dock.heading_rad)
        self._seen[:] = 0.0
        self._seen[3], self._seen[_HEADING] = NO_FIX, dock.heading_rad

    def measure(self, step: int, pose: Array, row: Array) -> None:
        """Fill the columns of a row, and the observation; the row has the true target already."""
        columns = row[WIDTH : WIDTH + DOCK_WIDTH]
        self._place(pose, columns)
        off = (pose[:3] - self._dock.seat_m).tolist()
        far = math.fsum(one * one for one in off) >= self._dock.least_range_m**2
        self._usbl.step(step, pose[:3], heard=far)
        self._positions[step] = pose[:3]
        self._ask(step, columns)
        self._look(step, pose, row[_TARGET], columns)
        search = self._search
        columns[_SEARCH : _SEARCH + 2] = search.searching, search.looked
        columns[_FOUND] = math.nan
        if search.best is not None:
            columns[_FOUND.start : _FOUND.stop - 1] = search.best.corners.ravel()
            columns[_FOUND.stop - 1] = search.best.confidence

    def _place(self, pose: Array, columns: Array) -> None:
        dock, (sine, cosine) = self._dock, self._turn
        north, east, down = (pose[:3] - dock.seat_m).tolist()
        turn = pose.item(5) - dock.heading_rad
        turn -= 2.0 * PI * math.floor((turn + PI) / (2.0 * PI))
        columns[_SEAT : _SEAT + 3], columns[_SEAT + 3] = dock.seat_m, dock.heading_rad
        columns[_OFF] = cosine * north + sine * east
        columns[_OFF + 1] = cosine * east - sine * north
        columns[_OFF + 2], columns[_OFF + 3] = down, turn
        columns[_DEPTH] = float(pose[2]) + dock.keel_m - dock.mouth_m

    def _ask(self, step: int, columns: Array) -> None:
        fix, told = self._usbl.last, columns[_FIX : _FIX + 8]
        if fix is None:
            told[:] = math.nan
            return
        away = self._dock.seat_m - fix.position_m  # of the dock, from where the vehicle was
        age = (step - fix.at_step) * self._step_s
        told[:3] = self._positions[fix.at_step] + away
        told[3:] = age, fix.sigma_m, fix.range_m, fix.bearing_rad, fix.elevation_rad
        self._seen[:3] = away
        self._seen[3], self._seen[4] = age, fix.sigma_m

    def _is_in_view(self, target: Array) -> bool:
        """Return whether a point (2,) [px] is in the image; nan is not."""
        return all(
            0.0 <= at <= 2.0 * middle
            for at, middle in zip(target.tolist(), self._dock.light.centre_px, strict=True)
        )

    def _look(self, step: int, pose: Array, target: Array, columns: Array) -> None:
        light = self._dock.light
        off = (light.at_m - pose[:3]).tolist()
        depths = light.attenuation_1_m * math.sqrt(math.fsum(one * one for one in off))
        shown = self._is_in_view(target) and depths <= light.most_depths
        here = target + self._noise[step] if shown else None
        columns[_LIGHT : _LIGHT + 2] = math.nan if here is None else here
        self._lights.append(here)
        seen = self._lights[0]
        self._seen[_VISIBLE] = seen is not None
        if seen is not None:
            self._seen[_SEEN_LIGHT] = seen - light.centre_px
