"""currents-v1: which position controller keeps station best while the current grows.

Five levels of 120 s each; at each the vehicle is put back and the tracker starts from the true
corners. Tags of the defaults: S sourced, D derived from sourced, E our estimate.
"""

import math
from typing import Final

from sim.benchmarks import Benchmark, Chart, Metric
from sim.configuration import Configuration, knob
from sim.registry import CRITERIA, METHODS, TRACKERS, TRUTH, VEHICLES, WARPS, labels

EXPERIMENT: Final = {"group": "Experiment", "role": "scenario"}
CURRENT: Final = {"group": "Current", "role": "scenario"}
WATER: Final = {"group": "Water and camera", "role": "scenario"}
SENSORS: Final = {"group": "Sensors", "role": "scenario", "advanced": True}
VELOCITY: Final = {"group": "Velocity controller", "role": "scenario", "advanced": True}
TRACKER: Final = {"group": "Tracker", "role": "solution"}
POSITION: Final = {"group": "Position controller", "role": "solution"}
WATER_TYPES = {
    "grey": "The same attenuation for every colour",
    "I": "Jerlov I (clearest ocean)",
    "IB": "Jerlov IB (clear ocean)",
    "II": "Jerlov II (ocean)",
    "III": "Jerlov III (turbid ocean)",
    "1C": "Jerlov 1C (clear coast)",
    "3C": "Jerlov 3C (coast)",
    "5C": "Jerlov 5C (turbid coast)",
    "7C": "Jerlov 7C (harbour)",
    "9C": "Jerlov 9C (turbid harbour)",
}


class CurrentsConfiguration(Configuration):
    """Settings of currents-v1. Seed, trials and controller are not part of it."""

    vehicle: str = knob(
        "girona500",
        title="Vehicle",
        says="The plant; it brings its own defaults.",
        choices=labels(VEHICLES),
        **EXPERIMENT,
    )
    levels: tuple[float, ...] = knob(
        (0.0, 0.1, 0.2, 0.3, 0.4),
        title="Current levels",
        says="Mean speed of the current at each level, in rising order.",
        unit="m/s",
        low=0,
        high=1,
        length=(1, 12),
        tag="S",
        **EXPERIMENT,
    )
    level_duration_s: float = knob(
        120.0,
        title="Length of a level",
        says="Simulated time before the vehicle is put back and the current grows.",
        unit="s",
        low=2,
        high=600,
        tag="S",
        **EXPERIMENT,
    )
    settle_s: float = knob(
        60.0,
        title="Settle window",
        says="Time at the start of each level that the settled metrics and the score leave out.",
        unit="s",
        low=0,
        high=599,
        tag="E",
        **EXPERIMENT,
    )
    control_period_s: float = knob(
        0.05,
        title="Control period",
        says="Time between two pictures and two steps of the controller.",
        unit="s",
        low=0.01,
        high=0.5,
        advanced=True,
        **EXPERIMENT,
    )
    physics_step_s: float = knob(
        0.01,
        title="Physics step",
        says="Step of the integrator (fourth-order Runge-Kutta).",
        unit="s",
        low=0.001,
        high=0.02,
        advanced=True,
        **EXPERIMENT,
    )
    altitude_m: float = knob(
        2.27,
        title="Camera above the target",
        says="Height of the camera above the target's top when a level starts.",
        unit="m",
        low=0.8,
        high=6,
        tag="D",
        **EXPERIMENT,
    )
    contact: bool = knob(
        True,
        title="Collisions",
        says="Whether the vehicle can hit the bottom and the target.",
        advanced=True,
        **EXPERIMENT,
    )

    current_law: str = knob(
        "relative",
        title="The current acts as",
        says="Relative velocity is physics; the body force is what the paper's simulator did.",
        choices={
            "relative": "Relative velocity of the water",
            "force": "Force on the body (the paper's simulator)",
        },
        **CURRENT,
    )
    current_azimuth_rad: float = knob(
        0.0,
        title="Direction of the current",
        says="Where the water comes from, relative to the bow: 0 bow-on, 1.57 from starboard (beam).",
        unit="rad",
        low=-math.pi,
        high=math.pi,
        tag="E",
        **CURRENT,
    )
    current_swing_rad: float = knob(
        0.7,
        title="Swing of the direction",
        says="Amplitude of the sinusoid in the direction.",
        unit="rad",
        low=0,
        high=1.57,
        tag="S",
        **CURRENT,
    )
    current_swing_period_s: float = knob(
        30.0,
        title="Period of the swing",
        says="Period of the sinusoid in the direction.",
        unit="s",
        low=1,
        high=600,
        tag="S",
        **CURRENT,
    )
    current_wave_m_s: float = knob(
        0.005,
        title="Wave of the speed",
        says="Amplitude of the sinusoid in the speed; level 0 has none.",
        unit="m/s",
        low=0,
        high=0.5,
        tag="S",
        **CURRENT,
    )
    current_wave_period_s: float = knob(
        4.0,
        title="Period of the wave",
        says="Period of the sinusoid in the speed.",
        unit="s",
        low=1,
        high=600,
        tag="S",
        **CURRENT,
    )
    current_gust: float = knob(
        0.05,
        title="Gusts",
        says="Standard deviation of the random part, as a share of the level.",
        low=0,
        high=0.5,
        tag="E",
        **CURRENT,
    )
    current_gust_time_s: float = knob(
        10.0,
        title="Gust time constant",
        says="How long a gust lasts (Ornstein-Uhlenbeck process).",
        unit="s",
        low=0.1,
        high=120,
        tag="E",
        **CURRENT,
    )
    current_force_share: float = knob(
        0.134,
        title="Share of the body force",
        says="Only with the body force: the share k of 410 k v^2 N that really acts; 0.134 gives the paper's 18 px.",
        low=0,
        high=1,
        tag="D",
        advanced=True,
        **CURRENT,
    )

    water_law: str = knob(
        "beer",
        title="Law of the water",
        says="How contrast decays with the distance.",
        choices={"beer": "Beer-Lambert attenuation", "uwsim": "UWSim fog"},
        **WATER,
    )
    water_type: str = knob(
        "IB",
        title="Type of water",
        says="Colour of the attenuation.",
        choices=WATER_TYPES,
        tag="S",
        **WATER,
    )
    water_attenuation_1_m: float = knob(
        0.2,
        title="Attenuation",
        says="Only with grey water: beam attenuation, or the fog's density.",
        unit="1/m",
        low=0,
        high=10,
        **WATER,
    )
    camera_noise_grey: float = knob(
        1.2,
        title="Camera noise",
        says="Standard deviation of the read noise in grey levels of 255.",
        unit="grey",
        low=0.8,
        high=64,
        tag="E",
        advanced=True,
        **WATER,
    )
    camera_width_px: int = knob(
        640,
        title="Picture width",
        says="Width of the camera's picture.",
        unit="px",
        low=160,
        high=1280,
        tag="S",
        advanced=True,
        **WATER,
    )
    camera_height_px: int = knob(
        480,
        title="Picture height",
        says="Height of the camera's picture.",
        unit="px",
        low=120,
        high=960,
        tag="S",
        advanced=True,
        **WATER,
    )
    camera_focal_px: float = knob(
        514.7,
        title="Focal length",
        says="Focal length of the camera.",
        unit="px",
        low=50,
        high=5000,
        tag="S",
        advanced=True,
        **WATER,
    )
    target_truth: str = knob(
        "centroid",
        title="True place of the target",
        says="Point that counts as the target's place in the picture.",
        choices={
            "centroid": "Centre of the top face",
            "uwsim": "Projected origin of the object (the paper)",
        },
        advanced=True,
        **WATER,
    )

    dvl_rate_hz: float = knob(
        5.0,
        title="DVL rate",
        says="Measurements per second.",
        unit="Hz",
        low=0.5,
        high=20,
        tag="S",
        **SENSORS,
    )
    dvl_sigma_m_s: float = knob(
        0.0015,
        title="DVL noise",
        says="Standard deviation per axis.",
        unit="m/s",
        low=0,
        high=0.2,
        tag="S",
        **SENSORS,
    )
    dvl_bias_m_s: float = knob(
        0.0,
        title="DVL bias",
        says="Constant error along each axis.",
        unit="m/s",
        low=-0.1,
        high=0.1,
        tag="E",
        **SENSORS,
    )
    dvl_scale_error: float = knob(
        0.0,
        title="DVL scale error",
        says="Relative error of the scale.",
        low=-0.1,
        high=0.1,
        tag="E",
        **SENSORS,
    )
    dvl_dropout: float = knob(
        0.0,
        title="DVL drop-outs",
        says="Share of the measurements that are missing.",
        low=0,
        high=0.9,
        tag="E",
        **SENSORS,
    )
    depth_sigma_m: float = knob(
        0.01,
        title="Depth noise",
        says="Standard deviation of the depth gauge.",
        unit="m",
        low=0,
        high=0.5,
        tag="S",
        **SENSORS,
    )
    ahrs_sigma_rad: float = knob(
        1e-4,
        title="Attitude noise",
        says="Standard deviation of roll, pitch and yaw.",
        unit="rad",
        low=0,
        high=0.1,
        tag="S",
        **SENSORS,
    )

    velocity_law: str = knob(
        "model",
        title="Velocity controller",
        says="How a velocity reference becomes thrust.",
        choices={
            "model": "DVL feedback + vehicle model, depth and heading held",
            "paper": "Proportional effort (the paper)",
        },
        group="Velocity controller",
        role="scenario",
    )
    reference_limit_m_s: float = knob(
        1.0,
        title="Largest reference",
        says="Velocity references are cut to this size on each axis.",
        unit="m/s",
        above=0,
        high=5,
        tag="E",
        **VELOCITY,
    )
    velocity_bandwidth_1_s: float = knob(
        1.0,
        title="Bandwidth of the feedback",
        says="Model law: proportional gain over the vehicle's mass.",
        unit="1/s",
        low=0,
        high=5,
        tag="E",
        **VELOCITY,
    )
    velocity_integral_1_s2: float = knob(
        0.2,
        title="Integral of the feedback",
        says="Model law: integral gain over the vehicle's mass.",
        unit="1/s^2",
        low=0,
        high=5,
        tag="E",
        **VELOCITY,
    )
    paper_gain_surge: float = knob(
        5.0,
        title="Effort per m/s in surge and heave",
        says="Paper's law: effort per m/s of error.",
        unit="s/m",
        low=0,
        high=50,
        tag="S",
        **VELOCITY,
    )
    paper_gain_sway: float = knob(
        6.0,
        title="Effort per m/s in sway",
        says="Paper's law: effort per m/s of error.",
        unit="s/m",
        low=0,
        high=50,
        tag="S",
        **VELOCITY,
    )

    tracker: str = knob(
        "esm",
        title="Tracker",
        says="Finds the target in the camera's picture.",
        choices=labels(TRACKERS) | {TRUTH: "Ground truth (no tracker; cannot rank)"},
        **TRACKER,
    )
    warp: str = knob(
        "homography",
        title="Warp",
        says="What movement of the target in the picture the tracker can follow.",
        choices=WARPS,
        **TRACKER,
    )
    criterion: str = knob(
        "zncc",
        title="Similarity",
        says="What the tracker compares pictures by.",
        choices=CRITERIA,
        **TRACKER,
    )
    method: str = knob(
        "esm", title="Method", says="How the tracker searches.", choices=METHODS, **TRACKER
    )
    start_error_px: float = knob(
        0.0,
        title="Error of the tracker's start",
        says="Standard deviation of the corners that the tracker starts from.",
        unit="px",
        low=0,
        high=10,
        group="Tracker",
        role="scenario",
        advanced=True,
    )

    kp: float = knob(
        0.5,
        title="Proportional gain Kp",
        says="Velocity reference per metre of error.",
        unit="1/s",
        low=0,
        high=5,
        tag="S",
        **POSITION,
    )
    ki: float = knob(
        0.02,
        title="Integral gain Ki",
        says="Velocity reference per metre of error and second; PI only.",
        unit="1/s^2",
        low=0,
        high=2,
        tag="S",
        **POSITION,
    )
    control_heave: bool = knob(
        False,
        title="Control the height too",
        says="Whether P and PI act on z; if not, the depth is held.",
        advanced=True,
        **POSITION,
    )

    def broken_rules(self) -> dict[str, str]:
        """Return setting -> sentence for the rules between several settings."""
        errors: dict[str, str] = {}
        if any(b <= a for a, b in zip(self.levels, self.levels[1:], strict=False)):
            errors["levels"] = "levels (Current levels) must rise from one to the next."
        if self.settle_s >= self.level_duration_s:
            errors["settle_s"] = (
                f"settle_s (Settle window) must be shorter than a level of {self.level_duration_s:g} s, "
                f"not {self.settle_s:g} s."
            )
        if not _multiple(self.control_period_s, self.physics_step_s):
            errors["control_period_s"] = (
                f"control_period_s (Control period) must be a whole multiple of the physics step of "
                f"{self.physics_step_s:g} s, not {self.control_period_s:g} s."
            )
        if not _multiple(self.level_duration_s, self.control_period_s):
            errors["level_duration_s"] = (
                f"level_duration_s (Length of a level) must be a whole multiple of the control period "
                f"of {self.control_period_s:g} s, not {self.level_duration_s:g} s."
            )
        if not _multiple(1.0 / self.dvl_rate_hz, self.physics_step_s):
            errors["dvl_rate_hz"] = (
                f"dvl_rate_hz (DVL rate) must make a period that is a whole multiple of the physics "
                f"step of {self.physics_step_s:g} s, such as 5 or 20 Hz, not {self.dvl_rate_hz:g} Hz."
            )
        return errors

    def why_not_ranked(self) -> dict[str, str]:
        """Return setting -> sentence for what keeps this configuration out of a ranked run."""
        if self.tracker == TRUTH:
            return {"tracker": "tracker (Tracker) must not be ground truth in a ranked run."}
        return {}

    def trial_duration_s(self) -> float:
        """Return the simulated length of all levels together."""
        return len(self.levels) * self.level_duration_s

    @property
    def steps_per_tick(self) -> int:
        """Physics steps between two control ticks."""
        return round(self.control_period_s / self.physics_step_s)

    @property
    def ticks_per_level(self) -> int:
        """Control ticks of one level."""
        return round(self.level_duration_s / self.control_period_s)


def _multiple(whole: float, part: float) -> bool:
    count = whole / part
    return round(count) >= 1 and abs(count - round(count)) < 1e-6


BENCHMARK = Benchmark(
    name="currents-v1",
    title="Position controllers in changing currents",
    summary=(
        "Keep station above a black box on the bottom while the current grows from 0 to 0.4 m/s in "
        "five levels of 120 s."
    ),
    compares="position controllers",
    headline=Metric("score", "Score", "of 100", "higher"),
    charts=(
        Chart("Distance to the target", "px", ("distance_px",)),
        Chart("X error", "px", ("error_x_px",)),
        Chart("Y error", "px", ("error_y_px",)),
        Chart("Distance to the station", "m", ("distance",)),
        Chart("Error as the controller sees it", "m", ("error_x", "error_y", "error_z")),
        Chart("Velocity reference", "m/s", ("ref_u", "ref_v", "ref_w")),
        Chart("Velocity by the DVL", "m/s", ("dvl_u", "dvl_v", "dvl_w")),
        Chart("Current", "m/s", ("current_x", "current_y", "current_z")),
        Chart("Tracker's error", "px", ("tracker_error",)),
        Chart("Thrust", "N", tuple(f"thrust_{i}" for i in range(5))),
        Chart("Depth", "m", ("z",)),
        Chart("Attitude", "rad", ("roll", "pitch", "yaw")),
    ),
    configuration=CurrentsConfiguration,
    presets={
        "girona500-uwsim": {
            "current_law": "force",
            "current_azimuth_rad": 1.5707963267948966,
            "current_wave_m_s": 0.0,
            "current_gust": 0.0,
            "velocity_law": "paper",
            "reference_limit_m_s": 5.0,
        }
    },
)
