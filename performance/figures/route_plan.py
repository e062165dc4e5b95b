"""A picture of a vehicle that follows a route, from above: what is done, what is to come, fixes."""

import math
from dataclasses import dataclass

import cv2
import numpy as np

from seamark.sim import registry
from seamark.sim.engine.replay import Image
from seamark.sim.engine.trial import run_trial
from seamark.sim.numerics.arrays import Array
from seamark.sim.recording.telemetry import INDEX, ROUTE_INDEX, Rows

SIZE = (480, 640)
MARGIN_PX = 48
SETTINGS = {"levels": [0.2], "route": "lemniscate", "level_duration_s": 60.0}
PROGRAM = "ilos"
TRIAL = 0
# blue, green, red; as in the scene of a run
WATER, GRID = (84, 80, 26), (98, 94, 38)
REST, DONE, WAY = (228, 222, 214), (148, 211, 94), (138, 224, 255)
FIX, CURRENT = (77, 160, 255), (255, 214, 88)
GRID_M = 2.0
_BITS = 4  # OpenCV draws at sixteenths of a pixel
_PLACE = [INDEX["x"], INDEX["y"]]


@dataclass(frozen=True, slots=True)
class _Plan:
    """From metres north and east to pixels, north up."""

    middle: Array  # (2,) [m]
    per_metre: float

    def at(self, places: Array) -> Array:
        """Return where places (k, 2) are in the picture, (k, 2) [px] from its upper left."""
        off = self.per_metre * (places - self.middle)
        return np.column_stack([SIZE[1] / 2 + off[:, 1], SIZE[0] / 2 - off[:, 0]])


def followed(name: str, seed: int) -> Image:
    """Return the plan of a route that a built-in program follows, (H, W, 3)."""
    config = registry.benchmark(name).read(SETTINGS)
    experiment = registry.benchmark(name).load()
    levels: list[Rows] = []
    program = experiment.built_in(PROGRAM, config)
    run_trial(name, config, program, seed=seed, trial=TRIAL, on_rows=levels.append)
    rows = np.concatenate(levels)
    plan = experiment.plan(config, seed=seed, trial=TRIAL)
    return drawn(np.array(plan.conditions["routes"][0])[:, :2], rows[: 2 * len(rows) // 3])


def drawn(route: Array, rows: Rows) -> Image:
    """Return the plan of a route (k, 2) [m] and of the rows of a vehicle up to a moment."""
    way, now = rows[:, _PLACE], rows[-1]
    everything = np.vstack([route, way])
    low, high = everything.min(axis=0), everything.max(axis=0)
    room = (np.array(SIZE) - 2 * MARGIN_PX) / (high - low)
    plan = _Plan((low + high) / 2, float(room.min()))
    image: Image = np.full((*SIZE, 3), WATER, np.uint8)
    _grid(image, plan)
    _line(image, plan.at(route), REST, 7)
    follows = rows[:, [ROUTE_INDEX["route_x"], ROUTE_INDEX["route_y"]]]
    _line(image, plan.at(follows), DONE, 7)
    for north, east, sigma in _fixes(rows):
        centre = plan.at(np.array([[north, east]]))[0]
        radius = round(sigma * plan.per_metre * (1 << _BITS))
        cv2.circle(image, _fine(centre), radius, FIX, 1, cv2.LINE_AA, _BITS)
    _line(image, plan.at(way), WAY, 2)
    _arrow(image, plan.at(way[-1:])[0], float(now[INDEX["yaw"]]))
    _current(image, now[[INDEX["current_x"], INDEX["current_y"]]])
    return image


def _fixes(rows: Rows) -> Array:
    """Return north, east and standard deviation of each fix, (k, 3) [m]."""
    fixes = rows[:, [ROUTE_INDEX[name] for name in ("fix_x", "fix_y", "fix_sigma")]]
    found: Array = np.unique(fixes[np.isfinite(fixes).all(axis=1)], axis=0)
    return found


def _grid(image: Image, plan: _Plan) -> None:
    reach = math.ceil(max(SIZE) / plan.per_metre / GRID_M) * GRID_M
    for off in np.arange(-reach, reach + GRID_M, GRID_M):
        x, y = plan.at(np.round(plan.middle[None] / GRID_M) * GRID_M + off)[0]
        cv2.line(image, (round(x), 0), (round(x), SIZE[0]), GRID, 1)
        cv2.line(image, (0, round(y)), (SIZE[1], round(y)), GRID, 1)


def _arrow(image: Image, centre: Array, heading: float) -> None:
    """Draw the vehicle as an arrow head."""
    ahead = np.array([math.sin(heading), -math.cos(heading)])
    right = np.array([-ahead[1], ahead[0]])
    corners = [18 * ahead, 11 * right - 12 * ahead, -6 * ahead, -11 * right - 12 * ahead]
    points = np.array([_fine(centre + corner) for corner in corners], np.int32)
    cv2.fillPoly(image, [points], WAY, cv2.LINE_AA, _BITS)


def _current(image: Image, velocity: Array) -> None:
    """Draw where the water flows to, in a corner."""
    along = np.array([velocity[1], -velocity[0]]) / float(np.hypot(*velocity))
    middle = np.array([SIZE[1] - 56.0, 56.0])
    start, end = _fine(middle - 26 * along), _fine(middle + 26 * along)
    cv2.arrowedLine(image, start, end, CURRENT, 3, cv2.LINE_AA, _BITS, 0.35)


def _line(image: Image, points: Array, colour: tuple[int, int, int], thickness: int) -> None:
    fine = np.round(points * (1 << _BITS)).astype(np.int32)
    cv2.polylines(image, [fine], False, colour, thickness, cv2.LINE_AA, _BITS)


def _fine(point: Array) -> tuple[int, int]:
    x, y = np.round(point * (1 << _BITS)).astype(int).tolist()
    return x, y
