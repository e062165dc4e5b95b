"""Plugging a connector: grip its handle, take it out, bring it over the receptacle, push it in.

The connector is parked beside the receptacle on a panel, whose letters tell where both are, and
whose corners, how it is tilted. It hangs upright from the jaws and in the middle across its handle,
so where the hand is, the peg is. On the way down, the force through the wrist limits how hard it
pushes. If the tip stands before the bore, the hand lifts it and tries places around, farther and
farther out. In the bore, whose axis turns the peg, the hand goes where the bore takes it.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

from seamark.sim.control.manipulation.approach import (
    BELIEVED_M,
    FALL,
    LOW_M,
    WORK,
    ArmCompensates,
    Steady,
    turned,
)
from seamark.sim.control.manipulation.arm_data import Vector
from seamark.sim.control.manipulation.arm_reading import data_of, mount_of
from seamark.sim.control.manipulation.kinematics import (
    ArmKinematics,
    Matrix,
    column,
    length,
    minus,
    plus,
    product,
    rotation,
    times,
)
from seamark.sim.control.manipulation.sight import Corners, Seen, find_tilted
from seamark.sim.control.observation import Observation
from seamark.sim.numerics.libm import PI, sincos
from seamark.sim.vehicles import load
from seamark.sim.vehicles.linkage_reading import load_linkage

TIP_M = 0.19  # below the middle of the handle
PARKED_M = 0.2  # along the letters from the receptacle
LEAST_SHARE = 0.01  # of a look in what is known of the panel's tilt
CLOSE_S, OPEN_S = 2.5, 2.0
EMPTY_RAD = -0.03  # of a jaw that has closed farther than a handle lets it
RISE_M_S, LOWER_M_S, INSERT_M_S = 0.06, 0.06, 0.02
CLEAR_M = 0.08  # of the tip above the face: out of the parking place
YIELD_S = 0.5
CARRY_M = 0.3  # of the tip above the face
OVER_M, OVER_S = 0.03, 1.5  # horizontally, for which it must be over the receptacle to come down
FACE_M = 0.03  # of the tip above the face, from where on it goes on slowly and feels
# Of the hand along the tool: most in the bore, and before it, where more would tip the peg over,
# since it swings in the jaws.
PUSH_N, TOUCH_N = 50.0, 20.0
GIVE_M = 0.005  # by which it gives way
SEATED_M = 0.072  # of the tip below the face, at the bottom of the bore
QUIET_S = 0.6  # over which the height is smoothed: the depth is noisy
AHEAD_M = 0.03  # of where the tip is asked to be, below it
CENTRE_M_S = 0.03  # of the hand towards the jaw that touches alone: as fast as that closes
STEP_M = 0.004  # of a tip that goes on sinking
STANDS_S, STUCK_S = 2.0, 6.0  # without that: at the bottom or before the bore, and within
# Places that are tried after the first: how far from it, by how much farther each, at most; and the
# angle from one to the next.
FIRST_M, STRIDE_M, WIDEST_M, TURN_RAD = 0.01, 0.004, 0.035, 2.4
LIFTED_M = 0.03  # of the tip above the face between them
# Of each axis of the DVL: the middle of the range that docs/benchmarks.md gives, and the signs.
DVL_ERROR_M_S = 0.0075
SIGNS = ((1.0, 1.0), (-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0))
AWAY_M = 0.45  # of the tool above a seated connector's handle
CLOSE, LIFT, CARRY, LOWER, INSERT, OPEN, LEAVE = range(WORK, WORK + 7)


class PlugConnector(Steady):
    """The steps of taking a connector, plugging it, and letting go."""

    ABOVE_M, SLOW_M, SETTLE_S, DRIFT = 0.6, 0.15, 6.0, 0.06
    BOTTOM_M = 0.0
    HANDLE_M = TIP_M
    HANDLE_RAD = 0.5 * PI
    IN_M: ClassVar[float] = 0.03  # of the tip below the face, in the bore
    CARRIES: ClassVar[frozenset[int]] = frozenset({CARRY, LOWER, INSERT})
    HOLDS: ClassVar[frozenset[int]] = frozenset({CLOSE, LIFT, CARRY, LOWER, INSERT})

    def __init__(self, config: Mapping[str, Any]) -> None:
        super().__init__(config)
        self._of_hand = self.kinematics
        vehicle, arm = load(config["vehicle"]), load_linkage(config["arm"])
        data = data_of(arm)
        (x, y, z), turn = data.tool
        tip = data._replace(tool=((x + TIP_M, y, z), turn))
        self._of_tip = ArmKinematics(tip, mount_of(vehicle, arm.name))

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Forget everything."""
        super().reset(level)
        self.into = (0.0, 0.0, 1.0)  # direction of the bore: north, east, down
        self.looks = 0  # from which that is known
        self.beside = (0.0, 0.0)  # [m] of the goal, north and east, in search
        self.held_at = (0.0, 0.0)  # [m] north and east of the hand from the connector
        self.tries, self.lifted = 0, False  # in search, and on the way to the next place
        self.stood = False  # on something
        self.height = 0.0  # [m] of the tool above a parked connector's handle
        self.over_s = self.stands_s = self.lowest = 0.0
        self.unloaded: float | None = None  # [N] through the wrist along the tool, in the water
        self.pushing = 0.0  # [N] of the hand along the tool

    def step(self, observation: Observation) -> Sequence[float]:
        """Return the command."""
        along = float(observation.wrist_force[0])
        if self.phase == CARRY:
            before = along if self.unloaded is None else self.unloaded
            self.unloaded = before + (along - before) * self.dt
        self.pushing = along - (self.unloaded or 0.0)
        self.kinematics = self._of_tip if self.phase in self.CARRIES else self._of_hand
        return super().step(observation)

    def _grip(self, observation: Observation, yaw: float) -> Vector:
        """Return where the hand should be, but for the height above it."""
        x, y, z = super()._grip(observation, yaw)
        north, east, down = self._goal()
        ahead, side = turned((north + self.beside[0], east + self.beside[1], 0.0), -yaw)
        return x + ahead, y + side, z + down

    def _goal(self) -> Vector:
        """Return where the hand, or the tip, should be from where `work` is: north, east, down."""
        if self.phase in self.CARRIES:
            return 0.0, 0.0, TIP_M
        return self._parked() if self.phase <= LIFT else (0.0, 0.0, 0.0)

    def _parked(self) -> Vector:
        """Return where the handle of a parked connector is, as far as it is known."""
        sine, cosine = sincos(self.handle - self.HANDLE_RAD)
        north, east, down = self.into
        letters = (cosine, sine, -(cosine * north + sine * east) / down)
        upright = minus((0.0, 0.0, TIP_M), times(self.into, TIP_M))
        return plus(times(letters, PARKED_M / length(letters)), upright)

    def _find(self, corners: Corners, tilt: Matrix) -> Seen | None:
        return find_tilted(corners, self.face_m, self.camera, tilt)

    def _learn(self, seen: Seen, yaw: float, observation: Observation) -> None:
        """Learn where the panel is, and how it is tilted, which does not change."""
        super()._learn(seen, yaw, observation)
        if self.phase < FALL:  # the hand has not hidden any of it
            self.looks += 1
            off = minus((*turned(seen.into, yaw), seen.into[2]), self.into)
            self.into = plus(self.into, times(off, max(1.0 / self.looks, LEAST_SHARE)))

    def _look(self, observation: Observation, tilt: Matrix, yaw: float) -> None:
        """Learn where the panel is, with the connector in the hand, too."""
        super()._look(observation, tilt, yaw)
        looks = self.phase == CARRY or (self.phase == LOWER and self.offset > LOW_M)
        seen = self._seen(observation, tilt) if looks else None
        if seen is not None and self.work is not None:
            north, east = turned(seen.centre, yaw)
            off = self.place[0] + north - self.work[0], self.place[1] + east - self.work[1]
            if off[0] * off[0] + off[1] * off[1] < BELIEVED_M * BELIEVED_M:
                self._correct((*off, 0.0))

    def _work(self, observation: Observation, error: Vector, joints: list[float]) -> None:
        self.height += (self.offset + error[2] - self.height) * self.dt / QUIET_S
        off = math.sqrt(error[0] * error[0] + error[1] * error[1])
        if self.phase == CLOSE:
            self._close(error)
        elif self.phase == LIFT:
            self._lift(error, joints)
        elif self.phase == CARRY:
            self._carry(off)
        elif self.phase == LOWER:
            self._lower(off)
        elif self.phase == INSERT:
            self._insert(error)
        else:
            self._leave()

    def _close(self, error: Vector) -> None:
        if self.since_s > CLOSE_S:
            self._hold(error)
            self._go(LIFT)

    def _hold(self, error: Vector) -> None:
        """Learn how the hand has the connector, whose tip stands on the face at its parking place.

        Jaws centre what they close on across its handle, so that nothing is known of that side.
        """
        if self.work is None:
            raise RuntimeError("the work has not been seen")
        north, east, down = self.work
        self.work = (north, east, down - self.height)
        ahead, side = turned(error, self.attitude[2])
        sine, cosine = sincos(self.handle)
        along = ahead * cosine + side * sine
        self.held_at = (-along * cosine, -along * sine)

    def _lift(self, error: Vector, joints: list[float]) -> None:
        if self.height < CLEAR_M:
            self._yield(error)
        if joints[self.jaw] < EMPTY_RAD:
            self._again()
        elif self._rise(CARRY_M):
            self.beside = self.held_at
            self._go(CARRY)

    def _carry(self, off: float) -> None:
        self.over_s = self.over_s + self.dt if off < OVER_M else 0.0
        if self.over_s > OVER_S:
            self._go(LOWER)

    def _leave(self) -> None:
        """Open the hand, then withdraw it."""
        if self.phase == OPEN and self.since_s > OPEN_S:
            self.offset = self.height
            self._go(LEAVE)
        elif self.phase == LEAVE:
            self._rise(AWAY_M)

    def _yield(self, error: Vector) -> None:
        """Let the hand be where it is pushed to: what it holds is held by something else, too."""
        north, east = turned(error, self.attitude[2])
        share = self.dt / YIELD_S
        self.beside = self.beside[0] - share * north, self.beside[1] - share * east

    def _rise(self, most: float) -> bool:
        """Return whether the hand is as high as this."""
        if self.offset < most:
            self.offset += RISE_M_S * self.dt
            self.falling = -RISE_M_S
        return self.offset >= most

    def _sink(self, speed: float) -> None:
        self.offset -= speed * self.dt
        self.falling = speed

    def _lower(self, off: float) -> None:
        if self.offset > FACE_M:
            if off < 2.0 * OVER_M:
                self._sink(LOWER_M_S)
        elif off < OVER_M:
            self._go(INSERT)

    def _insert(self, error: Vector) -> None:
        """Push; try beside if the tip stands before the bore, and let go if it does so within."""
        self.stands_s += self.dt
        if self.height < self.lowest - STEP_M:
            self.lowest, self.stands_s = self.height, 0.0
        inside = self.lowest < -self.IN_M
        if self.lifted:
            self._come_down_again()
        elif self.stands_s > (STANDS_S if self.lowest < -SEATED_M or not inside else STUCK_S):
            self._let_go() if inside else self._try_beside()
        elif self.pushing > (PUSH_N if inside else TOUCH_N):
            self.stood = True
            self.offset = max(self.offset, self.height + GIVE_M)
        elif self.offset > self.height - AHEAD_M:
            self._sink(INSERT_M_S)
        if inside:
            self._yield(error)

    def _let_go(self) -> None:
        self.offset = self.height
        self._go(OPEN)

    def _try_beside(self) -> None:
        """Lift the tip off, since it does not slide but tips over, and choose the next place."""
        self.tries += 1
        radius = min(FIRST_M + STRIDE_M * self.tries, WIDEST_M)
        sine, cosine = sincos(TURN_RAD * self.tries)
        self.beside = self.held_at[0] + radius * cosine, self.held_at[1] + radius * sine
        self.lifted, self.stood = True, False
        self.offset = self.height

    def _come_down_again(self) -> None:
        self._rise(LIFTED_M)
        if self.height > LIFTED_M - 0.01:
            self.lifted = False
            self.lowest, self.stands_s = self.height, 0.0

    def _again(self) -> None:
        super()._again()
        self.beside, self.tries = (0.0, 0.0), 0
        self.lowest, self.stood, self.lifted = 0.0, False, False

    def _jaw_speed(self, joints: list[float]) -> float:
        if self.phase in self.HOLDS:
            return -self.kinematics.fastest[self.jaw]
        return super()._jaw_speed(joints)


class Scripted(PlugConnector):
    """The vehicle alone goes where the hand is needed; the arm keeps one posture."""

    label = "Scripted: the vehicle brings the hand"


class Blind(Scripted):
    """Sees the panel once, at the start, then goes by dead reckoning and feels for the bar.

    It guesses the signs of the DVL's errors, which are never small. When the hand has closed on
    nothing, it guesses others, and goes where the bar would be then.
    """

    label = "Blind after the first look"
    ABOVE_M, SETTLE_S = 0.25, 0.0

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Forget everything."""
        super().reset(level)
        self.guesses, self.reckoned_s = 0, 0.0

    def _look(self, observation: Observation, tilt: Matrix, yaw: float) -> None:
        if self.work is None:
            super()._look(observation, tilt, yaw)

    def _reckon(self, velocity: Vector, yaw: float) -> None:
        self.reckoned_s += self.dt
        super()._reckon(minus(velocity, self._error()), yaw)

    def _error(self) -> Vector:
        """Return the errors of surge and sway by the DVL that it guesses [m/s]."""
        surge, sway = SIGNS[self.guesses % len(SIGNS)]
        return surge * DVL_ERROR_M_S, sway * DVL_ERROR_M_S, 0.0

    def _again(self) -> None:
        if self.phase >= WORK:
            before = self._error()
            self.guesses += 1
            moved = times(minus(before, self._error()), self.reckoned_s)
            for axis, off in enumerate(turned(moved, self.attitude[2])):
                self.place[axis] += off
        super()._again()


class ResolvedRate(ArmCompensates, PlugConnector):
    """The arm takes off what the vehicle leaves of the error, at the rate of its joints.

    It knows how the goal moves, so that the hand does not lag behind it, and follows the jaw that
    touches the bar first, so that the closing hand does not tilt the connector.
    """

    label = "Resolved rate: vehicle and arm together"
    GAIN_1_S = 0.7  # more, and the weight of the arm lets the vehicle roll
    BOTTOM_M = 0.01  # lower, and the jaws close on the peg below the bar, askew
    IN_M = 0.045  # below the funnel, in which it may stand on the edge of the bore

    def reset(self, level: Mapping[str, float | int]) -> None:
        """Forget everything."""
        super().reset(level)
        self.going = (0.0, 0.0)  # [m/s] of the goal, north and east

    def _from_the_goal(self, velocity: Vector) -> Vector:
        """Return the velocity without the drift, relative to a goal that moves."""
        north, east = (self.drift[axis] + self.going[axis] for axis in (0, 1))
        ahead, side = turned((north, east, 0.0), -self.attitude[2])
        return velocity[0] - ahead, velocity[1] - side, velocity[2] - self.falling

    def _correct(self, off: Vector) -> None:
        """Learn the drift until the work begins: the view from a carrying hand swings."""
        drift = [*self.drift]
        super()._correct(off)
        if self.phase >= WORK:
            self.drift = drift

    def _work(self, observation: Observation, error: Vector, joints: list[float]) -> None:
        super()._work(observation, error, joints)
        self.going = self._to_the_bar(observation, joints)
        north, east = (
            now + self.dt * speed for now, speed in zip(self.beside, self.going, strict=True)
        )
        self.beside = north, east

    def _to_the_bar(self, observation: Observation, joints: list[float]) -> tuple[float, float]:
        """Return how the closing hand goes to the side of the jaw that touches alone [m/s]."""
        port, starboard = observation.touch.tolist()[-2:]
        if self.phase != CLOSE or port == starboard:
            return 0.0, 0.0
        roll, pitch, yaw = self._attitude(observation)
        turn = product(rotation(roll, pitch, 0.0), self.kinematics.tool(joints).turn)
        speed = CENTRE_M_S if starboard else -CENTRE_M_S
        return turned(times(column(turn, 1), speed), yaw)

    def _folded(self) -> bool:
        return self._stiff()

    def _posture(self, joints: list[float], wrist: float) -> list[float]:
        """Return the speeds of the joints; the arm is stiff where something else holds the peg."""
        speeds = super()._posture(joints, wrist)
        if self._stiff():
            for number in self.kinematics.reaching:
                speeds[number] = 0.0
        return speeds

    def _stiff(self) -> bool:
        """Return whether something else holds the connector."""
        inserted = self.phase == INSERT and (self.stood or self.lowest < -self.IN_M)
        return inserted or self.phase == OPEN
