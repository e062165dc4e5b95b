"""currents-v1: which position controller keeps station best while the current grows.

Five levels of 120 s each; at each the vehicle is put back and the tracker starts from the true
corners. Tags of the defaults: S sourced, D derived from sourced, E our estimate.
"""

import math
from functools import partial

from sim.benchmarks import Benchmark, Chart, Metric
from sim.chain_settings import ChainSettings
from sim.configuration import knob
from sim.fault_settings import FaultSettings
from sim.observation import THRUSTERS
from sim.registry import TRUTH, VEHICLES, labels
from sim.scene_settings import SceneSettings
from sim.vehicles import load

experiment = partial(knob, group="Experiment", role="scenario")
current = partial(knob, group="Current", role="scenario")

TARGET_M = (0.42, 0.13)  # [m] length and width of the black box's top, S: UWSim
SMALLEST_SIDE_PX = 16.0  # [px] a smaller target gives a tracker nothing to start from
START_ERROR_SHARE = 0.1  # of the shorter side: the corners still make a convex figure


class CurrentsConfiguration(ChainSettings, SceneSettings, FaultSettings):
    """Settings of currents-v1. Seed, trials and controller are not part of it."""

    vehicle: str = experiment(
        "girona500",
        title="Vehicle",
        says="The plant; it brings its own defaults.",
        choices=labels(VEHICLES),
    )
    levels: tuple[float, ...] = experiment(
        (0.0, 0.1, 0.2, 0.3, 0.4),
        title="Current levels",
        says="Mean speed of the current at each level, in rising order.",
        unit="m/s",
        low=0,
        high=1,
        length=(1, 12),
        tag="S",
    )
    level_duration_s: float = experiment(
        120.0,
        title="Length of a level",
        says="Simulated time before the vehicle is put back and the current grows.",
        unit="s",
        low=2,
        high=600,
        tag="S",
    )
    settle_s: float = experiment(
        30.0,
        title="Settle window",
        says="Time at the start of each level that the settled metrics and the score leave out.",
        unit="s",
        low=0,
        high=599,
        tag="E",
    )
    control_period_s: float = experiment(
        0.05,
        title="Control period",
        says="Time between two pictures and two steps of the controller.",
        unit="s",
        low=0.01,
        high=0.5,
        advanced=True,
    )
    physics_step_s: float = experiment(
        0.01,
        title="Physics step",
        says="Step of the integrator (fourth-order Runge-Kutta).",
        unit="s",
        low=0.001,
        high=0.02,
        advanced=True,
    )
    altitude_m: float = experiment(
        2.27,
        title="Camera above the target",
        says="Height of the camera above the target's top when a level starts.",
        unit="m",
        low=0.8,
        high=6,
        tag="D",
    )
    contact: bool = experiment(
        True,
        title="Collisions",
        says="Whether the vehicle can hit the bottom.",
        advanced=True,
    )
    start_error_px: float = experiment(
        0.0,
        title="Error of the tracker's start",
        says="Standard deviation of the corners that the tracker starts from.",
        unit="px",
        low=0,
        high=10,
        advanced=True,
    )

    current_law: str = current(
        "relative",
        title="The current acts as",
        says="Relative velocity is physics; the body force is what the paper's simulator did.",
        choices={
            "relative": "Relative velocity of the water",
            "force": "Force on the body (the paper's simulator)",
        },
    )
    current_azimuth_rad: float = current(
        0.0,
        title="Direction of the current",
        says="Where the water comes from, from the bow: 0 bow-on, 1.57 starboard (beam).",
        unit="rad",
        low=-math.pi,
        high=math.pi,
        tag="E",
    )
    current_swing_rad: float = current(
        0.7,
        title="Swing of the direction",
        says="Amplitude of the sinusoid in the direction.",
        unit="rad",
        low=0,
        high=1.57,
        tag="S",
    )
    current_swing_period_s: float = current(
        30.0,
        title="Period of the swing",
        says="Period of the sinusoid in the direction.",
        unit="s",
        low=1,
        high=600,
        tag="S",
    )
    current_wave_m_s: float = current(
        0.005,
        title="Wave of the speed",
        says="Amplitude of the sinusoid in the speed; level 0 has none.",
        unit="m/s",
        low=0,
        high=0.5,
        tag="S",
    )
    current_wave_period_s: float = current(
        4.0,
        title="Period of the wave",
        says="Period of the sinusoid in the speed.",
        unit="s",
        low=1,
        high=600,
        tag="S",
    )
    current_gust: float = current(
        0.05,
        title="Gusts",
        says="Standard deviation of the random part, as a share of the level.",
        low=0,
        high=0.5,
        tag="E",
    )
    current_gust_time_s: float = current(
        10.0,
        title="Gust time constant",
        says="How long a gust lasts (Ornstein-Uhlenbeck process).",
        unit="s",
        low=0.1,
        high=120,
        tag="E",
    )
    current_force_share: float = current(
        0.134,
        title="Share of the body force",
        says="Only as body force, 410 k v² N: the share k; 0.134 gives the paper's 18 px.",
        low=0,
        high=1,
        tag="D",
        advanced=True,
    )

    def broken_rules(self) -> dict[str, str]:
        """Return setting -> sentence for the rules between several settings."""
        errors: dict[str, str] = {}
        if any(b <= a for a, b in zip(self.levels, self.levels[1:], strict=False)):
            errors["levels"] = "levels (Current levels) must rise from one to the next."
        if self.settle_s >= self.level_duration_s:
            errors["settle_s"] = (
                f"settle_s (Settle window) must be shorter than a level of "
                f"{self.level_duration_s:g} s, not {self.settle_s:g} s."
            )
        if not _multiple(self.control_period_s, self.physics_step_s):
            errors["control_period_s"] = (
                f"control_period_s (Control period) must be a whole multiple of the physics step "
                f"of {self.physics_step_s:g} s, not {self.control_period_s:g} s."
            )
        if not _multiple(self.level_duration_s, self.control_period_s):
            errors["level_duration_s"] = (
                f"level_duration_s (Length of a level) must be a whole multiple of the control "
                f"period of {self.control_period_s:g} s, not {self.level_duration_s:g} s."
            )
        if not _multiple(1.0 / self.dvl_rate_hz, self.physics_step_s):
            errors["dvl_rate_hz"] = (
                f"dvl_rate_hz (DVL rate) must make a period that is a whole multiple of the "
                f"physics step of {self.physics_step_s:g} s, such as 5 or 20 Hz, "
                f"not {self.dvl_rate_hz:g} Hz."
            )
        return errors | self._fault_rules() | self._picture_rules()

    def _fault_rules(self) -> dict[str, str]:
        count = len(load(self.vehicle).thrusters)
        errors: dict[str, str] = {}
        if self.fault_thruster >= count:
            errors["fault_thruster"] = (
                f"fault_thruster (Broken thruster) must be from -1 to {count - 1}: this vehicle "
                f"has {count} thrusters."
            )
        if self.fault_delay_s and not _multiple(self.fault_delay_s, self.control_period_s):
            errors["fault_delay_s"] = (
                f"fault_delay_s (Its delay) must be a whole multiple of the control period of "
                f"{self.control_period_s:g} s, not {self.fault_delay_s:g} s."
            )
        return errors

    def _picture_rules(self) -> dict[str, str]:
        """Refuse pictures in which no tracker could start."""
        errors: dict[str, str] = {}
        long, short = (side * self.camera_focal_px / self.altitude_m for side in TARGET_M)
        highest = TARGET_M[1] * self.camera_focal_px / SMALLEST_SIDE_PX
        if short < SMALLEST_SIDE_PX:
            errors["altitude_m"] = (
                f"altitude_m (Camera above the target) must be at most {highest:.2f} m with this "
                f"focal length, not {self.altitude_m:g} m: the target would be too small."
            )
        if long > self.camera_width_px or short > self.camera_height_px:
            errors["camera_focal_px"] = (
                f"camera_focal_px (Focal length) makes the target {long:.0f} x {short:.0f} px; it "
                f"must fit into {self.camera_width_px} x {self.camera_height_px} px."
            )
        if self.start_error_px > START_ERROR_SHARE * short:
            errors["start_error_px"] = (
                f"start_error_px (Error of the tracker's start) must be at most "
                f"{START_ERROR_SHARE * short:.1f} px, a tenth of the target's shorter side, "
                f"not {self.start_error_px:g} px."
            )
        return errors

    def why_not_ranked(self) -> dict[str, str]:
        """Return setting -> sentence for what keeps this configuration out of a ranked run."""
        if self.tracker == TRUTH:
            return {"tracker": "tracker (Tracker) must not be ground truth in a ranked run."}
        return {}

    def idle_columns(self) -> frozenset[str]:
        """Return the thrusts that the vehicle does not have, and the contact force without any."""
        count = len(load(self.vehicle).thrusters)
        idle = {f"thrust_{i}" for i in range(count, THRUSTERS)}
        return frozenset(idle if self.contact else idle | {"contact_n"})

    def trial_duration_s(self) -> float:
        """Return the simulated length of all levels together."""
        return len(self.levels) * self.level_duration_s

    @property
    def steps_per_tick(self) -> int:
        """Physics steps between two control ticks."""
        return round(self.control_period_s / self.physics_step_s)

    @property
    def dvl_period_ticks(self) -> int:
        """Physics steps between two measurements of the DVL."""
        return round(1.0 / (self.dvl_rate_hz * self.physics_step_s))

    @property
    def ticks_per_level(self) -> int:
        """Control ticks of one level."""
        return round(self.level_duration_s / self.control_period_s)


def _multiple(whole: float, part: float) -> bool:
    count = whole / part
    return round(count) >= 1 and abs(count - round(count)) < 1e-6


# What the published experiment has beside its vehicle's own defaults.
PAPER_SCENE = {
    "water_law": "uwsim",
    "water_type": "grey",
    "water_attenuation_1_m": 0.1,  # S: UWSim's default fog
    "range_from": "start",
    "level_out_tilt": False,
    "heading_hold": False,
    "depth_hold": False,
}


def _presets() -> dict[str, dict[str, object]]:
    """Return vehicle -> values that come with its choice."""
    own = {name: dict(load(name).defaults) for name in VEHICLES}
    own["girona500-uwsim"] |= PAPER_SCENE
    return {name: values for name, values in own.items() if values}


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
        Chart("Thrust", "N", tuple(f"thrust_{i}" for i in range(THRUSTERS))),
        Chart("Contact force", "N", ("contact_n",)),
        Chart("Depth", "m", ("z",)),
        Chart("Attitude", "rad", ("roll", "pitch", "yaw")),
    ),
    configuration=CurrentsConfiguration,
    groups=(
        "Experiment",
        "Position controller",
        "Tracker",
        "Current",
        "Water and camera",
        "Station keeper",
        "Velocity controller",
        "Sensors",
        "Faults",
    ),
    presets=_presets(),
)
