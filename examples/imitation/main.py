"""A learned controller for recover-v1: a network that imitates a state machine, with its memory.

Beside it in the archive are policy.onnx, the network, and policy.json, what is known of the arm.
The network gets what `Features` makes of an observation and returns the command and the phase of
the work, which is its memory: it is part of the features of the next step.
"""

import json
import math
from pathlib import Path

import numpy as np

PHASES = 5  # see, come, fall, close, lift
SEE, COME, FALL, CLOSE, LIFT = range(PHASES)
NEAR_M, LOOK_M = 0.1, 0.3
LEARN, DRIFT = 0.25, 0.06  # shares of what was seen in what is remembered
MOST_DRIFT_M_S, BELIEVED_M, LOW_M = 0.02, 0.03, 0.15
KI, MOST_INTEGRAL = 0.15, 0.1
LONGEST_S = 8.0
SIDES_DIFFER = 0.2  # by which the sides of what is seen may differ from those of the box


class Features:
    """What the network gets: where the handle is by sight and dead reckoning, and what is felt.

    Only additions, multiplications, divisions and square roots: the same bits on every processor.
    """

    def __init__(self, config, tool):
        self.focal = config["camera_focal_px"]
        self.middle = (
            0.5 * (config["camera_width_px"] - 1),
            0.5 * (config["camera_height_px"] - 1),
        )
        self.mount, self.face = config["camera_mount_m"], config["face_m"]
        self.tool = tool  # in the body, with the arm in its working posture [m]
        self.reset()

    def reset(self):
        """Forget everything."""
        self.phase, self.since_s, self.near_s = SEE, 0.0, 0.0
        self.box = None  # [m] ahead and to starboard, and its depth
        self.along = (1.0, 0.0)  # direction of its long side
        self.drift = [0.0, 0.0]  # [m/s]
        self.integral = [0.0, 0.0]  # [m/s]
        self.depth_before = None

    def update(self, o):
        """Return the features of an observation, 36 numbers."""
        roll, pitch, _ = o.attitude
        level = tilt(roll, pitch)
        speed = applied(level, o.velocity)
        turn = o.rates[2] * o.dt
        if self.depth_before is None:
            self.depth_before = o.depth
        if self.box is not None:
            x, y, depth = self.box
            x -= (speed[0] - self.drift[0]) * o.dt
            y -= (speed[1] - self.drift[1]) * o.dt
            self.box = [x + turn * y, y - turn * x, depth]
            for pair in (self.drift, self.integral):
                pair[:] = pair[0] + turn * pair[1], pair[1] - turn * pair[0]
        seen = bool(o.target_visible) and self.phase < CLOSE
        if seen:
            self._look(o, level)
        self.since_s += o.dt
        off = [0.0, 0.0, 0.0]
        if self.box is not None:
            tool = applied(level, self.tool)
            off = [self.box[0] - tool[0], self.box[1] - tool[1], self.box[2] - o.depth - tool[2]]
            self._integrate(off, o.dt)
        phase = [1.0 if self.phase == one else 0.0 for one in range(PHASES)]
        return [
            *(2.0 * clipped(each, 1.0) for each in off),
            *(10.0 * clipped(each, NEAR_M) for each in off[:2]),
            5.0 * clipped(off[2], 0.2),
            *self.along,
            *(10.0 * each for each in self.integral),
            *(5.0 * each for each in speed),
            5.0 * o.rates[2],
            5.0 * roll,
            5.0 * pitch,
            *o.joints,
            sum_of(o.touch),
            *(0.05 * each for each in o.wrist_force),
            0.1 * o.joint_efforts[-1],
            min(self.since_s, LONGEST_S) / LONGEST_S,
            min(self.near_s, LONGEST_S) / LONGEST_S,
            2.0 * (o.depth - self.depth_before),
            1.0 if seen else 0.0,
            1.0 if self.box is not None else 0.0,
            *phase,
        ]

    def advance(self, phase, depth):
        """Take the phase that the network has come to."""
        if phase != self.phase:
            self.phase, self.since_s, self.near_s, self.depth_before = phase, 0.0, 0.0, depth

    def _integrate(self, off, dt):
        if math.sqrt(off[0] * off[0] + off[1] * off[1]) < LOOK_M:
            self.near_s += dt
        for axis in (0, 1):
            if self.phase != LIFT and abs(off[axis]) < NEAR_M:
                moved = self.integral[axis] + KI * off[axis] * dt
                self.integral[axis] = clipped(moved, MOST_INTEGRAL)

    def _look(self, o, level):
        """Learn where the box is, and the drift of the dead reckoning."""
        found = self._found(o.corners, level)
        if found is None:
            return
        (x, y, z), self.along = found
        if self.box is None:
            self.box = [x, y, z + o.depth]
            return
        off = [x - self.box[0], y - self.box[1], z + o.depth - self.box[2]]
        if self.phase == FALL:  # the hand hides a part of it
            low = self.box[2] - o.depth - applied(level, self.tool)[2] < LOW_M
            if low or off[0] * off[0] + off[1] * off[1] > BELIEVED_M * BELIEVED_M:
                return
            off[2] = 0.0
        self.box = [was + LEARN * each for was, each in zip(self.box, off)]  # noqa: B905
        for axis in (0, 1):
            self.drift[axis] = clipped(self.drift[axis] + DRIFT * off[axis], MOST_DRIFT_M_S)

    def _found(self, corners, level):
        """Return the middle of the face from the body's origin [m], and its direction; or None."""
        points = []
        for k in range(4):
            right = (corners[2 * k] - self.middle[0]) / self.focal
            down = (corners[2 * k + 1] - self.middle[1]) / self.focal
            x, y, z = applied(level, (-down, right, 1.0))
            if not z > 0.1:
                return None
            points.append((x / z, y / z))
        a, b, c, d = points
        long, short = (apart(a, b), apart(d, c)), (apart(a, d), apart(b, c))
        total = long[0] + long[1] + short[0] + short[1]
        if not total > 1e-9:
            return None
        depth = 2.0 * (self.face[0] + self.face[1]) / total
        for sides, true in ((long, self.face[0]), (short, self.face[1])):
            if any(abs(depth * side / true - 1.0) > SIDES_DIFFER for side in sides):
                return None
        mount = applied(level, self.mount)
        x, y = (0.25 * depth * (a[i] + b[i] + c[i] + d[i]) for i in (0, 1))
        ahead, side = b[0] - a[0] + c[0] - d[0], b[1] - a[1] + c[1] - d[1]
        size = math.sqrt(ahead * ahead + side * side)
        place = (mount[0] + x, mount[1] + y, mount[2] + depth)
        return place, (ahead / size, side / size)


class Controller:
    def __init__(self, config):
        import onnxruntime  # noqa: PLC0415  # to train needs none

        folder = Path(__file__).parent
        known = json.loads((folder / "policy.json").read_text())
        self.features = Features(config, known["tool_m"])
        self.most = known["most"]  # that the expert ever commanded
        self.network = onnxruntime.InferenceSession(str(folder / "policy.onnx"))

    def reset(self, level):
        self.features.reset()

    def step(self, observation):
        features = self.features.update(observation)
        given = np.asarray([features], np.float32)
        command, phase = self.network.run(None, {"features": given})
        self.features.advance(int(phase[0].argmax()), observation.depth)
        pairs = zip(command[0].tolist(), self.most)  # noqa: B905
        return [clipped(value, most) for value, most in pairs]


def tilt(roll, pitch):
    """Return the rotation from body axes to level ones, of small angles."""
    sr, cr = roll - roll * roll * roll / 6.0, 1.0 - 0.5 * roll * roll
    sp, cp = pitch - pitch * pitch * pitch / 6.0, 1.0 - 0.5 * pitch * pitch
    return (cp, sp * sr, sp * cr), (0.0, cr, -sr), (-sp, cp * sr, cp * cr)


def applied(matrix, v):
    """Return a vector in other axes."""
    return [row[0] * v[0] + row[1] * v[1] + row[2] * v[2] for row in matrix]


def apart(a, b):
    """Return the distance of two points."""
    return math.sqrt((b[0] - a[0]) * (b[0] - a[0]) + (b[1] - a[1]) * (b[1] - a[1]))


def clipped(value, most):
    """Return a number within plus or minus `most`."""
    return min(max(value, -most), most)


def sum_of(values):
    """Return a sum, added from left to right."""
    total = 0.0
    for each in values:
        total += float(each)
    return total
