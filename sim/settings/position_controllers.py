"""Settings of the built-in position controllers, each shown with those that use it.

Tags of the defaults: S sourced, D derived from sourced, E our estimate.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from seamark.sim.settings.configuration import Configuration
from seamark.sim.settings.setting import setting

UPLOAD = "upload"  # a program of the user's gets the whole configuration
PI_SETTINGS = {  # of sim/settings/control_loop.py
    "kp": ("p", "pi", UPLOAD),
    "ki": ("pi", UPLOAD),
    "control_heave": ("p", "pi", UPLOAD),
}


def position_setting(default: object, *controllers: str, **keywords: Any) -> Any:  # as `setting`
    """Return a setting of these controllers."""
    applies: dict[str, Sequence[str]] = {"controller": controllers}
    return setting(
        default, group="Position controller", role="solution", applies=applies, **keywords
    )


class PositionControllerSettings(Configuration):
    """Gains and options of the controllers that only station keeping offers."""

    @classmethod
    def applies(cls, name: str) -> Mapping[str, Sequence[str]]:
        """Return also which controllers use the gains of P and PI."""
        users = PI_SETTINGS.get(name)
        return {**super().applies(name), **({"controller": users} if users else {})}

    heading_gain_1_s: float = position_setting(
        1.2,
        *("pid", "pi-ff", "smc", "lqr", "mpc", "l1", UPLOAD),
        title="Heading gain",
        help="Yaw rate per radian of heading error.",
        unit="1/s",
        low=0,
        high=2,
        tag="E",
        source="well below the heading hold's 2 rad/s",
    )
    pid_kp: float = position_setting(
        2.0,
        "pid",
        title="Proportional gain of PID",
        help="Velocity reference per metre of error.",
        unit="1/s",
        low=0,
        high=5,
        tag="E",
        source="scan on seeds that no benchmark uses",
    )
    pid_ki: float = position_setting(
        0.8,
        "pid",
        title="Integral gain of PID",
        help="Change of the velocity reference per second and metre of error.",
        unit="1/s²",
        low=0,
        high=5,
        tag="E",
        source="scan on seeds that no benchmark uses",
    )
    pid_kd: float = position_setting(
        1.5,
        "pid",
        title="Derivative gain of PID",
        help="Velocity reference opposing each m/s measured by the DVL.",
        low=0,
        high=5,
        tag="E",
        source="scan on seeds that no benchmark uses",
    )
    pi_ff_kp: float = position_setting(
        2.0,
        "pi-ff",
        title="Proportional gain with feed-forward",
        help="Velocity reference per metre of error.",
        unit="1/s",
        low=0,
        high=5,
        tag="E",
        source="scan on seeds that no benchmark uses",
    )
    pi_ff_ki: float = position_setting(
        0.5,
        "pi-ff",
        title="Integral gain with feed-forward",
        help="Change of the velocity reference per second and metre of error.",
        unit="1/s²",
        low=0,
        high=5,
        tag="E",
        source="scan on seeds that no benchmark uses",
    )
    pi_ff_kd: float = position_setting(
        1.5,
        "pi-ff",
        title="Damping with feed-forward",
        help="Velocity reference opposing each m/s measured by the DVL.",
        low=0,
        high=5,
        tag="E",
        source="scan on seeds that no benchmark uses",
    )
    pi_ff_observer_1_s: float = position_setting(
        1.5,
        "pi-ff",
        title="Bandwidth of the disturbance observer",
        help="How fast the estimate of the water's force follows.",
        unit="1/s",
        low=0,
        high=10,
        tag="E",
        source="scan on seeds that no benchmark uses",
    )
    smc_surface_1_s: float = position_setting(
        2.0,
        "smc",
        title="Sliding surface λ",
        help="How fast the error decays on the sliding surface.",
        unit="1/s",
        above=0,
        high=5,
        tag="E",
        source="scan on seeds that no benchmark uses",
    )
    smc_water_m_s2: float = position_setting(
        0.1,
        "smc",
        title="Change of the water",
        help="Greatest acceleration of the water that super-twisting has to follow.",
        unit="m/s²",
        low=0,
        high=5,
        tag="E",
        source="scan on seeds that no benchmark uses",
    )
    smc_boundary_m_s: float = position_setting(
        0.15,
        "smc",
        title="Boundary layer φ",
        help="Distance from the surface within which a ramp replaces the switching.",
        unit="m/s",
        above=0,
        high=1,
        tag="E",
        source="scan on seeds that no benchmark uses",
    )
    lqr_bandwidth: float = position_setting(
        0.7,
        "lqr",
        title="Bandwidth of the regulator",
        help="Multiplied by the lag of the thrusters plus 0.1 s of latency, so that one value "
        "suits all vehicles.",
        above=0,
        high=5,
        tag="E",
        source="scan on seeds that no benchmark uses",
    )
    lqr_water_m_s2: float = position_setting(
        0.05,
        "lqr",
        title="Change of the water",
        help="Noise density with which the Kalman filter lets the water accelerate.",
        unit="m/s²/√Hz",
        above=0,
        high=5,
        tag="E",
        source="scan on seeds that no benchmark uses",
    )
    lqr_delay_s: float = position_setting(
        0.05,
        "lqr",
        title="Delay of the images",
        help="Age of an image that the Kalman filter assumes.",
        unit="s",
        low=0,
        high=0.5,
        tag="E",
        source="scan on seeds that no benchmark uses",
    )
    mpc_bandwidth: float = position_setting(
        1.1,
        "mpc",
        title="Bandwidth of MPC",
        help="Multiplied by the lag of the thrusters plus 0.1 s of latency, as for LQG.",
        above=0,
        high=5,
        tag="E",
        source="scan on seeds that no benchmark uses",
    )
    mpc_horizon_s: float = position_setting(
        2.0,
        "mpc",
        title="Horizon",
        help="How far ahead the moves are planned.",
        unit="s",
        low=0.1,
        high=5,
        tag="E",
        source="scan on seeds that no benchmark uses",
    )
    mpc_water_m_s2: float = position_setting(
        0.05,
        "mpc",
        title="Change of the water",
        help="Noise density with which the Kalman filter lets the water accelerate.",
        unit="m/s²/√Hz",
        above=0,
        high=5,
        tag="E",
        source="scan on seeds that no benchmark uses",
    )
    mpc_camera_delay_s: float = position_setting(
        0.05,
        "mpc",
        title="Delay of the images",
        help="Age of an image that the Kalman filter assumes.",
        unit="s",
        low=0,
        high=0.5,
        tag="E",
        source="scan on seeds that no benchmark uses",
    )
    mpc_command_delay_s: float = position_setting(
        0.0,
        "mpc",
        title="Delay of the commands",
        help="Time that a command is assumed to be on its way.",
        unit="s",
        low=0,
        high=0.5,
        tag="E",
        source="scan on seeds that no benchmark uses",
    )
    l1_bandwidth: float = position_setting(
        0.7,
        "l1",
        title="Bandwidth of L1 control",
        help="Multiplied by the lag of the thrusters plus 0.1 s of latency, as for LQG.",
        above=0,
        high=5,
        tag="E",
        source="scan on seeds that no benchmark uses",
    )
    l1_predictor_1_s: float = position_setting(
        0.5,
        "l1",
        title="Rate of the predictor",
        help="How fast the error of the state predictor decays.",
        unit="1/s",
        low=0.01,
        high=20,
        tag="E",
        source="scan on seeds that no benchmark uses",
    )
    l1_filter_1_s: float = position_setting(
        1.0,
        "l1",
        title="Bandwidth of the filter",
        help="Up to which frequency the estimated disturbance is cancelled.",
        unit="1/s",
        low=0.01,
        high=20,
        tag="E",
        source="scan on seeds that no benchmark uses",
    )
