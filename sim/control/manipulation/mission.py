"""A whole mission: search for the right box, look at it closely, recover it, bring it back.

What is done with the box is `recover`'s. Places are north and east of the start, by dead reckoning;
the depth is that of the depth gauge.
"""

import math
from collections.abc import Mapping
from typing import ClassVar

from seamark.sim.control.manipulation import recover
from seamark.sim.control.manipulation.approach import SEE, Approach, turned
from seamark.sim.control.manipulation.arm_data import Vector
from seamark.sim.control.manipulation.kinematics import Matrix, applied, minus, rotation
from seamark.sim.control.observation import Observation
from seamark.sim.numerics.libm import PI, sincos

SEARCH, INSPECT = SEE - 2, SEE - 1  # phases before those of an approach
HOME = recover.LIFT + 1
Point = tuple[float, float]  # [m] north, east

# E: all of these, tried on seeds 5 to 8.
ARRIVED_M = 0.4  # of a place on the way, so that the vehicle need not stop there
RINGS_M = (1.3, 2.2)  # radii of the rings around the place told, after its middle
LOWER_M = 0.7  # by which a second and all further rounds are lower
CLOSE_M = 1.15  # of the camera above the face, where letters can be read
SURE, RIGHT, UNSURE = 0.7, 0.55, 0.3  # confidences, see `_judge`
CENTRED_M = 0.25  # of the camera from above the box, to judge
JUDGED_S, LONGEST_S = 2.5, 7.0  # for which it looks from close by, at least and at most
LOST_S = 3.0  # without the box, before it goes on
SAME_M = 0.6  # between sightings of one box


class Traveller(recover.Recover):
    """Goes from place to place first, with the camera above each."""

    FASTEST_M_S = 0.4

    def _camera_place(self, tilt: Matrix, yaw: float) -> Point:
        """Return where the camera is."""
        north, east = turned(applied(tilt, self.camera.mount_m), yaw)
        return self.place[0] + north, self.place[1] + east

    def _go_on(self, off: Point, down: float, yaw: float, observation: Observation) -> list[float]:
        """Return surge, sway and heave to what is so far off, north and east, and so far down."""
        ahead, side = turned((*off, 0.0), -yaw)
        self.falling = 0.0
        return Approach._fly(self, (ahead, side, down), yaw, observation)


class Delivery(Traveller):
    """A recovery that goes on: the box is brought to where the vehicle started."""

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Forget everything."""
        super().reset(level)
        self.unknown_s = 0.0  # for which the drift of the reckoning was not yet known
        self._home: Point | None = None

    def step(self, observation: Observation) -> list[float]:
        """Return the command."""
        if self._home is None:
            self._reckon((0.0, 0.0, 0.0), 0.0)
            self._home = self.place[0], self.place[1]
        if self.work is None:
            self.unknown_s += self.dt
        return list(super().step(observation))

    def _work(self, observation: Observation, error: Vector, joints: list[float]) -> None:
        super()._work(observation, error, joints)
        risen = self._depth(observation) - self.goal_depth < 0.1 * recover.LIFT_M
        if self.phase == recover.LIFT and risen:
            self._reckon_back()
            self._go(HOME)
        elif self.phase == HOME and self._empty(joints):
            self._again()

    def _reckon_back(self) -> None:
        """Take the drift off that the reckoning had before it was known."""
        north, east = (one * self.unknown_s for one in self.drift)
        self.place = [self.place[0] - north, self.place[1] - east]
        if self.work is not None:
            self.work = minus(self.work, (north, east, 0.0))
        self.unknown_s = 0.0

    def _fly(self, error: Vector, yaw: float, observation: Observation) -> list[float]:
        if self.phase != HOME:
            return super()._fly(error, yaw, observation)
        ahead, side = turned(self._way_home(), -yaw)
        roll, pitch, _ = self._attitude(observation)
        point = self.kinematics.tool(self._joints(observation)).point
        tool = applied(rotation(roll, pitch, 0.0), point)
        wanted = ahead - tool[0], side - tool[1], 0.0
        surge, sway, _ = Approach._fly(self, wanted, yaw, observation)
        return [surge, sway, self._rise(observation)]

    def _way_home(self) -> Vector:
        """Return how far the start is, north and east."""
        north, east = self._home or (0.0, 0.0)
        return north - self.place[0], east - self.place[1], 0.0

    def _folded(self) -> bool:
        return self.phase >= recover.LIFT


class Chain(Delivery, recover.ResolvedRate):
    """Searches in rings around the place told, and reads the letters of each box from close by.

    Whether it is the right box, the detector says: the confidence of what the tracker has.
    """

    label = "Built-in chain: search, recognise, recover, return"

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Forget everything."""
        super().reset(level)
        self.phase = SEARCH
        self._home = 0.0, 0.0
        self.at = 0  # number of the place on the way
        self.depth_m: float | None = None  # of the start
        self.wrong: list[Point] = []  # boxes that are not the right one
        self.box: Vector = (0.0, 0.0, 0.0)  # [m] the one that is inspected: north, east, depth
        self.close_s = self.unseen_s = 0.0

    def step(self, observation: Observation) -> list[float]:
        """Return the command."""
        if self.phase >= SEE:
            return super().step(observation)
        roll, pitch, yaw = self._attitude(observation)
        tilt, joints = rotation(roll, pitch, 0.0), self._joints(observation)
        self._reckon(applied(tilt, self._velocity(observation)), yaw)
        self.since_s += self.dt
        self.unknown_s += self.dt
        if self.depth_m is None:
            self.depth_m = self._depth(observation)
        seen = self._sighting(observation, tilt, yaw)
        if self.phase == SEARCH:
            self._search(seen)
        else:
            self._inspect(seen, observation)
        here, (north, east, depth) = self._camera_place(tilt, yaw), self._goal(observation)
        if self.phase == SEARCH and math.dist(here, (north, east)) < ARRIVED_M:
            self.at += 1
        off, down = (north - here[0], east - here[1]), depth - self._depth(observation)
        return [*self._go_on(off, down, yaw, observation), 0.0, *self._posture(joints, 0.0)]

    def _sighting(self, observation: Observation, tilt: Matrix, yaw: float) -> Vector | None:
        """Return where the face of a box is, unless it is known to be a wrong one."""
        seen = self._seen(observation, tilt)
        if seen is None:
            return None
        north, east = turned(seen.centre, yaw)
        place = self.place[0] + north, self.place[1] + east
        if any(math.dist(place, one) < SAME_M for one in self.wrong):
            return None
        return *place, self._depth(observation) + seen.centre[2]

    def _search(self, seen: Vector | None) -> None:
        if seen is not None:
            self.box, self.close_s, self.unseen_s = seen, 0.0, 0.0
            self._go(INSPECT)

    def _inspect(self, seen: Vector | None, observation: Observation) -> None:
        """Follow the box, and decide whether it is the right one."""
        if seen is None:
            self.unseen_s += self.dt
            if self.unseen_s > LOST_S:
                self._go(SEARCH)
            return
        self.unseen_s = 0.0
        self.box = seen
        camera = seen[2] - self._depth(observation) - self.camera.mount_m[2]
        if camera < CLOSE_M + CENTRED_M:
            self.close_s += self.dt
        self._judge(observation.confidence)

    def _judge(self, confidence: float) -> None:
        """Take the box, if it is surely the right one, or after a while rather that than not."""
        if confidence >= SURE and self.since_s > 1.0:
            self._go(SEE)
        elif self.close_s > LONGEST_S and confidence >= RIGHT:
            self._go(SEE)
        elif (self.close_s > JUDGED_S and confidence < UNSURE) or self.close_s > LONGEST_S:
            self.wrong.append(self.box[:2])
            self._go(SEARCH)

    def _goal(self, observation: Observation) -> Vector:
        """Return where the camera should be, north and east, and the depth of the vehicle."""
        if self.phase == INSPECT:
            north, east, depth = self.box
            return north, east, depth - CLOSE_M - self.camera.mount_m[2]
        told: list[float] = observation.told.tolist()
        rounds, number = divmod(self.at, len(PLACES))
        north, east = PLACES[number]
        depth = (self.depth_m or 0.0) + (LOWER_M if rounds else 0.0)
        return told[0] + north, told[1] + east, depth


def _ring(radius_m: float) -> list[Point]:
    """Return places on a ring, about as far from each other as its radius."""
    turns = (sincos(PI / 3.0 * k) for k in range(6))
    return [(radius_m * cosine, radius_m * sine) for sine, cosine in turns]


PLACES: tuple[Point, ...] = ((0.0, 0.0), *(place for ring in RINGS_M for place in _ring(ring)))


class Lawnmower(Traveller):
    """Flies lanes over the place told, and never looks."""

    label = "Blind lawnmower"
    LANES: ClassVar[tuple[Point, ...]] = tuple(
        (1.8 * end * (-1.0) ** lane, 0.9 * (lane - 2)) for lane in range(5) for end in (-1.0, 1.0)
    )

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Forget everything."""
        super().reset(level)
        self.at = 0

    def step(self, observation: Observation) -> list[float]:
        """Return the command."""
        roll, pitch, yaw = self._attitude(observation)
        tilt, joints = rotation(roll, pitch, 0.0), self._joints(observation)
        self._reckon(applied(tilt, self._velocity(observation)), yaw)
        here, told = self._camera_place(tilt, yaw), observation.told.tolist()
        lane = self.LANES[min(self.at, len(self.LANES) - 1)]
        goal = told[0] + lane[0], told[1] + lane[1]
        if math.dist(here, goal) < ARRIVED_M:
            self.at += 1
        off = goal[0] - here[0], goal[1] - here[1]
        return [*self._go_on(off, 0.0, yaw, observation), 0.0, *self._posture(joints, 0.0)]
