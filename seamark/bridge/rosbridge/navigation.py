"""Where the vehicle believes it is: dead reckoning from what its own sensors measure."""

from seamark.bridge.rosbridge.axes import Quaternion
from seamark.sim.control.observation import Observation
from seamark.sim.numerics.libm import sincos


class DeadReckoning:
    """Position north and east of the start of a level [m]; it drifts, as on a real vehicle.

    The velocity is that of the DVL, the attitude that of the AHRS, the depth that of the gauge.
    """

    def __init__(self) -> None:
        self.north_m = self.east_m = self.down_m = 0.0
        self.orientation: Quaternion = (0.0, 0.0, 0.0, 1.0)
        self._speed = (0.0, 0.0)  # [m/s] north, east, over the time until the next step

    def reset(self) -> None:
        """Begin at the origin."""
        self.north_m = self.east_m = 0.0
        self._speed = (0.0, 0.0)

    def step(self, seen: Observation) -> None:
        """Advance to the time of an observation."""
        self.north_m += self._speed[0] * seen.dt
        self.east_m += self._speed[1] * seen.dt
        self.down_m = seen.depth
        roll, pitch, yaw = seen.attitude.tolist()
        self.orientation = _quaternion(roll, pitch, yaw)
        self._speed = _over_ground(seen.velocity.tolist(), roll, pitch, yaw)


def _over_ground(
    velocity: list[float], roll: float, pitch: float, yaw: float
) -> tuple[float, float]:
    """Return the velocity north and east of one in the body frame (Fossen 2021, eq. 2.18)."""
    u, v, w = velocity
    (sr, cr), (sp, cp), (sy, cy) = sincos(roll), sincos(pitch), sincos(yaw)
    north = cy * cp * u + (cy * sp * sr - sy * cr) * v + (cy * sp * cr + sy * sr) * w
    east = sy * cp * u + (sy * sp * sr + cy * cr) * v + (sy * sp * cr - cy * sr) * w
    return float(north), float(east)


def _quaternion(roll: float, pitch: float, yaw: float) -> Quaternion:
    (sr, cr), (sp, cp), (sy, cy) = sincos(0.5 * roll), sincos(0.5 * pitch), sincos(0.5 * yaw)
    return (
        float(sr * cp * cy - cr * sp * sy),
        float(cr * sp * cy + sr * cp * sy),
        float(cr * cp * sy - sr * sp * cy),
        float(cr * cp * cy + sr * sp * sy),
    )
