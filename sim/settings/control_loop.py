"""Settings of the chain: tracker, position controller, velocity controller.

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
        help="Velocity reference per metre of error and second; PI only.",
        unit="1/s²",
        low=0,
        high=2,
        tag="S",
        source="Pérez et al., the published experiment",
    )
    control_heave: bool = position_setting(
        False,
        title="Control the height too",
        help="Whether P and PI act on z; if not, the depth is held.",
        advanced=True,
    )

    velocity_law: str = velocity_setting(
        "model",
        title="Velocity controller",
        help="How a velocity reference becomes thrust.",
        choices={
            "model": "DVL feedback + vehicle model, depth and heading held",
            "paper": "Proportional effort (the paper)",
        },
    )
    reference_limit_m_s: float = velocity_setting(
        1.0,
        title="Largest reference",
        help="Velocity references are cut to this size on each axis.",
        unit="m/s",
        above=0,
        high=5,
        tag="E",
        source="the real vehicle's greatest speed ahead",
        advanced=True,
    )
    velocity_bandwidth_1_s: float = velocity_setting(
        2.0,
        title="Bandwidth of the feedback",
        help="Model law: gain over the vehicle's mass.",
        unit="1/s",
        low=0,
        high=5,
        tag="E",
        source="well below the thrusters' 5 1/s",
        advanced=True,
    )
    velocity_observer_1_s: float = velocity_setting(
        0.0,  # proportional, as in the published experiment: the current is the position's task
        title="Speed of the observer",
        help="Model law: how fast it learns the current's force by itself; 0 leaves it to you.",
        unit="1/s",
        low=0,
        high=5,
        tag="E",
        source="off: the integral term of the position controller is compared",
        advanced=True,
    )
    paper_gain_surge: float = velocity_setting(
        5.0,
        title="Effort per m/s in surge and heave",
        help="Paper's law: effort per m/s of error.",
        unit="s/m",
        low=0,
        high=50,
        tag="S",
        source="benchmark_software_launcher ea65b39, velocity controller",
        advanced=True,
    )
    paper_gain_sway: float = velocity_setting(
        6.0,
        title="Effort per m/s in sway",
        help="Paper's law: effort per m/s of error.",
        unit="s/m",
        low=0,
        high=50,
        tag="S",
        source="benchmark_software_launcher ea65b39, velocity controller",
        advanced=True,
    )
    heading_hold: bool = velocity_setting(
        True, title="Hold the heading", help="Yaw rates turn a held heading.", advanced=True
    )
    depth_hold: bool = velocity_setting(
        True, title="Hold the depth", help="Heave references move a held depth.", advanced=True
    )
    tilt_hold: bool = velocity_setting(
        False,
        title="Hold roll and pitch",
        help="Model law: thrusters level the vehicle; for those that the current would turn over.",
        advanced=True,
    )
    range_from: str = station_keeper_setting(
        "altitude",
        title="Distance from",
        help="What turns pixels into metres.",
        choices={
            "altitude": "Measured altitude",
            "size": "Known size of the target",
            "start": "Height at the level's start (the paper)",
        },
        advanced=True,
    )
    level_out_tilt: bool = station_keeper_setting(
        True,
        title="Level out the tilt",
        help="Whether roll and pitch are taken out of the target's place.",
        advanced=True,
    )
