"""Settings of interventions: an arm that works on something, in levels of increasing current.

Tags of the defaults: S sourced, D derived from sourced, E our estimate.
"""

from typing import Any

from seamark.sim.settings.arm import GROUP as ARM
from seamark.sim.settings.arm import ArmSettings, arm_setting
from seamark.sim.settings.current_levels import CurrentLevels
from seamark.sim.settings.experiment import experiment_setting
from seamark.sim.settings.setting import override
from seamark.sim.settings.tracker import RobustTrackerSettings
from seamark.sim.settings.trial_spreads import GROUP as SPREADS
from seamark.sim.settings.trial_spreads import TrialSpreadSettings, spread_setting
from seamark.sim.vehicles import load
from seamark.sim.vehicles.linkage import Linkage
from seamark.sim.vehicles.linkage_reading import load_linkage

ARMED = ArmSettings.model_fields
# Vehicles that carry an arm with a hand.
VEHICLES = ("girona500", "bluerov2-heavy", "bluerov2-heavy-v2")
HANDS = ("arm-5e-like", "alpha-like")  # arms with jaws
# Body frame: before the arm's base, where the view of the hand is free. E: on a bracket beside it.
MOUNTS_M = {"girona500": (1.25, -0.35, 0.2)}
OTHER_MOUNT_M = (0.42, -0.14, 0.05)


class InterventionSettings(RobustTrackerSettings, ArmSettings, CurrentLevels, TrialSpreadSettings):
    """A vehicle with an arm above what it works on, in a current that a level sets."""

    vehicle: str = experiment_setting(
        "girona500",
        title="Vehicle",
        help="Vehicle that carries the arm.",
        choices={name: load(name).title for name in VEHICLES},
    )
    arm: str = arm_setting(
        "arm-5e-like",
        title="Arm",
        help="Arm on the vehicle, whose joints the program moves.",
        choices={name: load_linkage(name).title for name in HANDS},
    )
    levels: tuple[float, ...] = experiment_setting(
        (0.0, 0.1, 0.2, 0.3, 0.4, 0.5),
        title="Current levels",
        help="Mean speed of the current at each level, in increasing order; they run in an order "
        "that is drawn.",
        unit="m/s",
        low=0,
        high=1,
        length=(1, 12),
        tag="E",
        source="beyond what the oracle holds; see docs/benchmarks.md",
    )
    level_duration_s: float = override(
        ARMED["level_duration_s"],
        90.0,
        help="Simulated time of an attempt; then everything returns to its start and the current "
        "changes.",
        tag="E",
        source="three times what the oracle takes",
    )
    camera_width_px: int = override(ARMED["camera_width_px"], 320)
    camera_height_px: int = override(ARMED["camera_height_px"], 240)
    camera_focal_px: float = override(
        ARMED["camera_focal_px"],
        190.0,
        tag="S",
        source="field of view of 80 degrees, like the camera of a BlueROV2",
    )
    images: str = override(ARMED["images"], "none", role="solution")
    encoder_bias_rad: float = spread_setting(
        0.01,
        title="Bias of encoders",
        help="Constant error of each joint of the arm, drawn uniformly within plus or minus this.",
        unit="rad",
        low=0,
        high=0.2,
        tag="E",
        source="an arm whose zeros were set by eye, 0.6°",
    )
    focal_spread: float = spread_setting(
        0.01,
        title="Focal length error",
        help="Focal length of the vehicle's camera, drawn uniformly within plus or minus this "
        "share of its setting, which programs are told.",
        low=0,
        high=0.2,
        tag="E",
        source="a calibration in the water of a pool",
    )
    friction_spread: float = spread_setting(
        0.3,
        title="Friction spread",
        help="Coefficients of friction of what is worked on, drawn uniformly within plus or minus "
        "this share.",
        low=0,
        high=0.9,
        tag="E",
        source="growth and wear",
    )

    tilt_spread_rad: float = spread_setting(
        0.14,
        title="Tilt",
        help="Angle by which what is worked on is tilted, drawn uniformly from 0 to this; the "
        "level axis about which it is tilted has any direction.",
        unit="rad",
        low=0,
        high=0.25,
        tag="E",
        source="8°: a seabed that is no floor",
    )
    turbidity_spread: float = spread_setting(
        2.5,
        title="Turbidity",
        help="Optical depth that suspended matter adds on the way from the camera at the start to "
        "what is worked on, drawn uniformly from 0 to this, alike for all colours.",
        low=0,
        high=6,
        tag="E",
        source="what the default tracker still follows; see docs/benchmarks.md",
    )

    def camera_mount_m(self) -> tuple[float, float, float]:
        """Return where the vehicle's camera is on the body [m]."""
        return MOUNTS_M.get(self.vehicle, OTHER_MOUNT_M)

    def base_levels(self) -> tuple[float, ...]:
        """Return the mean speeds [m/s] without a grid."""
        return self.levels

    def cross_field_errors(self) -> dict[str, str]:
        """Return setting -> message for the rules between several settings."""
        return super().cross_field_errors() or self.grid_errors()

    def has_workpiece(self) -> bool:
        """Return whether the arm works on something that telemetry follows: always."""
        return True

    def the_arm(self) -> Linkage:
        """Return the arm.

        Raises
        ------
        ValueError
            There is none.
        """
        arm = self.chosen_arm()
        if arm is None:
            raise ValueError("an intervention needs an arm")
        return arm

    def for_program(self) -> dict[str, Any]:
        """Return the settings that a program is given, and what it knows of camera and work."""
        face = self.target_shape()
        known = {"camera_mount_m": self.camera_mount_m(), "face_m": (face.length_m, face.width_m)}
        return super().for_program() | known


GROUPS = (
    *("Experiment", ARM, "Position controller", "Tracker", "Grid", "Current"),
    *("Water and camera", "Station keeper", "Velocity controller", "Sensors", "Faults", SPREADS),
)
