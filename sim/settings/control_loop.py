"""Settings of the control loop: tracker, position controller, velocity controller.

Tags of the defaults: S sourced, D derived from sourced, E our estimate.
"""

from functools import partial

from seamark.sim.settings.setting import setting
from seamark.sim.settings.tracker import TrackerSettings

velocity_setting = partial(setting, group="Velocity controller", role="scenario")
station_keeper_setting = partial(setting, group="Station keeper", role="scenario")
position_setting = partial(setting, group="Position controller", role="solution")


class ControlLoopSettings(TrackerSettings):
    """Tracker, position controller and velocity controller."""

    kp: float = position_setting(
        0.5,
        title="Proportional gain Kp",
        help="Velocity reference per metre of error.",
        unit="1/s",
        low=0,
        high=5,
        tag="S",
        source="Pérez et al., the published experiment",
    )
    ki: float = position_setting(
        0.02,
        title="Integral gain Ki",
        help="Change of the velocity reference per second and metre of error; PI only.",
        unit="1/s²",
        low=0,
        high=2,
        tag="S",
        source="Pérez et al., the published experiment",
    )
    control_heave: bool = position_setting(
        False,
        title="Control heave",
        help="Whether P and PI also act on z; otherwise the depth is held.",
        advanced=True,
    )

    velocity_law: str = velocity_setting(
        "model",
        title="Velocity controller",
        help="How velocity references are converted to thrust.",
        choices={
            "model": "DVL feedback + vehicle model, depth and heading held",
            "paper": "Proportional effort (the paper)",
        },
    )
    reference_limit_m_s: float = velocity_setting(
        1.0,
        title="Velocity reference limit",
        help="Velocity references are saturated at this value on each axis.",
        unit="m/s",
        above=0,
        high=5,
        tag="E",
        source="the real vehicle's maximum forward speed",
        advanced=True,
    )
    velocity_bandwidth_1_s: float = velocity_setting(
        2.0,
        title="Feedback bandwidth",
        help="Model law: feedback gain divided by the vehicle's mass.",
        unit="1/s",
        low=0,
        high=5,
        tag="E",
        source="well below the thrusters' 5 1/s",
        advanced=True,
    )
    velocity_observer_1_s: float = velocity_setting(
        0.0,  # proportional, as published: rejecting the current is up to the position controller
        title="Observer bandwidth",
        help="Model law: how fast it estimates the current's force; 0: left to your controller.",
        unit="1/s",
        low=0,
        high=5,
        tag="E",
        source="off: the benchmark compares the integral action of position controllers",
        advanced=True,
    )
    paper_gain_surge: float = velocity_setting(
        5.0,
        title="Surge and heave gain",
        help="The paper's law: effort per m/s of velocity error.",
        unit="s/m",
        low=0,
        high=50,
        tag="S",
        source="benchmark_software_launcher ea65b39, velocity controller",
        advanced=True,
    )
    paper_gain_sway: float = velocity_setting(
        6.0,
        title="Sway gain",
        help="The paper's law: effort per m/s of velocity error.",
        unit="s/m",
        low=0,
        high=50,
        tag="S",
        source="benchmark_software_launcher ea65b39, velocity controller",
        advanced=True,
    )
    heading_hold: bool = velocity_setting(
        True,
        title="Hold the heading",
        help="Yaw rate commands turn the heading reference.",
        advanced=True,
    )
    depth_hold: bool = velocity_setting(
        True,
        title="Hold the depth",
        help="Heave references move the depth reference.",
        advanced=True,
    )
    tilt_hold: bool = velocity_setting(
        False,
        title="Hold roll and pitch",
        help="Model law: the thrusters keep the vehicle level against tilting by the current.",
        advanced=True,
    )
    range_from: str = station_keeper_setting(
        "altitude",
        title="Range source",
        help="The range with which pixels are converted to metres.",
        choices={
            "altitude": "Measured altitude",
            "size": "Known size of the target",
            "start": "Altitude at the start of the level (the paper)",
        },
        advanced=True,
    )
    level_out_tilt: bool = station_keeper_setting(
        True,
        title="Compensate tilt",
        help="Whether the target's image position is compensated for roll and pitch.",
        advanced=True,
    )
